//! Rule `dark-emitter`: an emitter emits.
#![doc = include_str!("dark_emitter.md")]

use super::{Level, Report, Rule, Subject};
use crate::ir::{Scene, Shape};
use crate::mesh::{View, area};

pub(super) const RULE: Rule = Rule {
    id: "dark-emitter",
    level: Level::Warn,
    summary: "An emitter sends out nothing, or too little to be told from nothing.",
    doc: include_str!("dark_emitter.md"),
    targets: &[],
    check,
};

/// The smallest number of a half-float image, 2^-24: Mitsuba 0.x writes such images by default, and rounds less to 0.
const LEAST: f64 = 5.960_464_477_539_063e-8;

/// The share of the strongest emitter's radiance and power below which another one is lost in the rounding of a sum in single
/// precision.
const SHARE: f64 = 1e-6;

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let emitters = || scene.surfaces().filter_map(|(origin, shape)| Some((origin, shape, shape.emission.as_ref()?)));
    let brightest = emitters().max_by(|a, b| a.2.radiance.max().total_cmp(&b.2.radiance.max()));
    let note = "renderers choose lights by their power, and waste samples on one that adds nothing, or leave it out; a reader takes \
                it for a light";
    let help = |what: &str| format!("give it {what} that shows, or make it a `shape`, or remove it");
    for (origin, shape, emission) in emitters() {
        let radiance = emission.radiance.max();
        let message = if radiance == 0.0 {
            format!("the emitter `{}` emits nothing", shape.name)
        } else if radiance < LEAST {
            format!("the emitter `{}` has a radiance of {radiance:e}, which a half-float image rounds to 0", shape.name)
        } else if let Some((_, other, strongest)) = brightest
            && radiance < SHARE * strongest.radiance.max()
            && radiance * size(scene, shape) < SHARE * strongest.radiance.max() * size(scene, other)
        {
            format!("the emitter `{}` emits less than a millionth of what `{}` does", shape.name, other.name)
        } else {
            continue;
        };
        report.add(origin, message, "this emitter", note, help("a radiance"));
    }
    for (origin, light) in scene.lights.entries().filter(|(_, light)| light.kind.color().is_black()) {
        let message = format!("the light `{}` sends out nothing", light.name);
        report.add(origin, message, "this light", note, "give it a strength that shows, or remove it".to_owned());
    }
}

/// The area of a shape at its place, as if the transform scaled alike in all directions; what places its group is left out.
fn size(scene: &Scene, shape: &Shape) -> f64 {
    let scale = libm::cbrt(shape.transform.determinant().abs());
    scale * scale * area(View::from(&scene.meshes[shape.mesh]))
}
