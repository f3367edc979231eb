//! Materials: parameters in the ranges that [`Bsdf`] documents.

use crate::diag::{Finding, Origin};
use crate::ir::{Bsdf, Color, Material, Scene, Sides};

use super::fits;

pub(super) fn check(scene: &Scene, findings: &mut Vec<Finding>) {
    for (handle, Material { name, bsdf, sides }) in scene.materials.iter() {
        let mut checker = Checker { name, origin: scene.materials.origin(handle), findings };
        if *sides == Sides::Front && bsdf.is_clear() {
            checker.wrong("it is a dielectric, which has no sides, and scatters light on one side only");
        }
        match bsdf {
            Bsdf::Diffuse { reflectance } => {
                // What a texture holds is for the renderer to read.
                if let Some(color) = reflectance.color() {
                    checker.reflectance(color);
                }
            }
            Bsdf::Mirror { reflectance } => checker.reflectance(reflectance),
            Bsdf::Plastic { reflectance, ior, alpha } => {
                if let Some(color) = reflectance.color() {
                    checker.reflectance(color);
                }
                checker.number("index of refraction", *ior, "above 1", |x| x > 1.0);
                checker.alpha(*alpha);
            }
            Bsdf::Principled { base, metallic, roughness, ior } => {
                if let Some(color) = base.color() {
                    checker.reflectance(color);
                }
                checker.number("metallic", *metallic, "between 0 and 1", |x| (0.0..=1.0).contains(&x));
                checker.number("roughness", *roughness, "between 0 and 1", |x| (0.0..=1.0).contains(&x));
                checker.number("index of refraction", *ior, "above 1", |x| x > 1.0);
            }
            Bsdf::Conductor { eta, k, alpha } => {
                checker.color("eta", eta, "positive", |x| x > 0.0);
                checker.color("k", k, "0 or more", |x| x >= 0.0);
                checker.alpha(*alpha);
            }
            Bsdf::Dielectric { interior, exterior, alpha } => {
                checker.number("interior index of refraction", *interior, "positive", |x| x > 0.0);
                checker.number("exterior index of refraction", *exterior, "positive", |x| x > 0.0);
                checker.alpha(*alpha);
            }
        }
    }
}

struct Checker<'a> {
    name: &'a str,
    origin: &'a Origin,
    findings: &'a mut Vec<Finding>,
}

impl Checker<'_> {
    fn reflectance(&mut self, color: &Color) {
        self.color("reflectance", color, "0 or more", |x| x >= 0.0);
    }

    fn alpha(&mut self, alpha: f64) {
        self.number("alpha", alpha, "0 or more", |x| x >= 0.0);
    }

    fn color(&mut self, what: &str, color: &Color, range: &str, holds: impl Fn(f64) -> bool) {
        let fault = color.rgb().into_iter().find(|x| !fits(*x) || !holds(*x));
        self.fault(what, fault, range);
    }

    fn number(&mut self, what: &str, value: f64, range: &str, holds: impl Fn(f64) -> bool) {
        let fault = Some(value).filter(|x| !fits(*x) || !holds(*x));
        self.fault(what, fault, range);
    }

    fn fault(&mut self, what: &str, value: Option<f64>, range: &str) {
        if let Some(value) = value {
            self.wrong(&format!("the {what} is {value}, it must be {range} and at most 1e30"));
        }
    }

    fn wrong(&mut self, what: &str) {
        let message = format!("material `{}`: {what}", self.name.escape_debug());
        self.findings.push(Finding::error("invalid-material", self.origin.clone(), message));
    }
}
