//! Camera, image, depth and the lights without a surface.

use super::look::off;
use super::{Asked, Found, TEXT, inexact, unsupported};
use crate::capability::{self, Feature, Support, of_texture, sampler_feature};
use crate::formats::Target;
use crate::formats::shared::camera;
use crate::formats::shared::images::Use;
use crate::formats::shared::reading::{Clip, Light, Reading, Rgb, Sampling, View};
use crate::ir::{
    Axes, Camera, ColorOrTexture, Film, Filter, Integrator, LightKind, LightSource, Sampler, Vec3, length, normalized,
    sub,
};

/// How far an angle of a cone in degrees may be off: TEXT of the largest, which is 90.
const ANGLE: f64 = 90.0 * TEXT;

/// What a format may take off the inner cone of a sharp edge, of the cone: a millionth in glTF, where it must be smaller, and the rounding
/// of what is written.
const EDGE: f64 = 1.001e-6;

/// How far a principal point may be off, in pixels.
const PIXEL: f64 = 1e-6;

pub(super) fn compare(asked: &Asked<'_>, target: &Target, reading: &Reading, found: &mut Found) {
    found.stands_in(reading.settings.as_ref());
    let Film { width, height, filter: _ } = &asked.scene.film;
    match reading.film {
        Some(film) if film == [*width, *height] => {}
        Some([w, h]) => found.differs(format!("the image has {w} x {h} pixels instead of {width} x {height}")),
        None => found.differs("the files give no size of the image"),
    }
    if !reading.replaced.filter {
        filter(asked, target, reading, found);
    }
    if !reading.replaced.integrator {
        depth(asked, target, reading, found);
    }
    match &reading.view {
        _ if reading.replaced.camera => {}
        Some(view) => view_differs(asked, view, found),
        None => found.differs("the files give no camera"),
    }
    if !reading.replaced.integrator {
        algorithm(asked, target, reading, found);
    }
    clip(asked, reading, found);
    if !reading.replaced.sampler {
        sampling(asked, target, reading, found);
    }
    found.stands_in(reading.description.as_ref());
    lights(asked, target, &reading.lights, found);
}

/// The algorithm and what it takes; where a target lacks it, path tracing stands for it.
fn algorithm(asked: &Asked<'_>, target: &Target, reading: &Reading, found: &mut Found) {
    let integrator = &asked.scene.integrator;
    let lacks = unsupported(&(target.supports)(capability::algorithm(integrator).0));
    let wanted = if lacks && reading.noted.is_none() { "path" } else { integrator.word() };
    if let Some(said) = reading.algorithm
        && said != wanted
    {
        found.differs(format!("the algorithm is `{said}` instead of `{wanted}`"));
    }
    let (radius, count) = reading.photons;
    let Film { width, height, filter } = &asked.scene.film;
    let first = camera::photon_radius(asked.scene);
    if let Some(said) = radius.filter(|said| off(*said, first, TEXT * first)) {
        found.differs(format!("photons are gathered within {said} instead of {first}"));
    }
    let photons = i64::from(width.saturating_mul(*height).min(reading.most.unwrap_or(u32::MAX)));
    if let Some(said) = count.filter(|said| *said != photons) {
        found.differs(format!("a pass has {said} photons instead of {photons}"));
    }
    if let Some(said) = reading.noted.as_ref().filter(|said| *said != filter) {
        found.differs(format!("the filter is {said:?} instead of {filter:?}"));
    }
}

/// Clipping distances: those of the camera, and where it leaves them open those that a writer makes for its program.
fn clip(asked: &Asked<'_>, reading: &Reading, found: &mut Found) {
    let camera = &asked.scene.cameras[asked.camera];
    // A reader whose format has them says so with the camera.
    let Some(Clip { near, far, default }) = reading.clip else { return };
    let shown = |distance: Option<f64>| distance.map_or("none".to_owned(), |distance| distance.to_string());
    let mut compare = |name: &str, said: Option<f64>, wanted: Option<f64>| {
        let same = match (said, wanted) {
            (Some(said), Some(wanted)) => !off(said, wanted, TEXT * wanted),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        if !same {
            found.differs(format!("the distance `{name}` is {} instead of {}", shown(said), shown(wanted)));
        }
    };
    match default {
        Some(default) => {
            let (front, back) = camera::clipping(asked.scene, camera, default);
            compare("near", near.or(Some(default.0)), front.or(Some(default.0)));
            compare("far", far.or(Some(default.1)), back.or(Some(default.1)));
        }
        None => {
            compare("near", near, Some(camera::must_near(asked.scene, camera)));
            compare("far", far, camera.far);
        }
    }
}

fn sampling(asked: &Asked<'_>, target: &Target, reading: &Reading, found: &mut Found) {
    let sampler = &asked.scene.sampler;
    let Sampling { samples, passes: _, seed, sobol } = &reading.sampling;
    let wanted = i64::from(sampler.samples().min(reading.most.unwrap_or(u32::MAX)));
    if let Some(other) = samples.iter().find(|samples| **samples != wanted) {
        found.differs(format!("there are {other} samples instead of {wanted}"));
    } else if samples.is_empty() {
        found.differs("the files give no samples");
    }
    if let Some((said, of)) = seed
        && *said != of(sampler.seed())
    {
        found.differs(format!("the seed is {said} instead of {}", of(sampler.seed())));
    }
    let feature = sampler_feature(sampler, &asked.scene.integrator);
    let is_sobol = matches!(sampler, Sampler::Sobol { .. });
    // Where a target has no such points for this algorithm, independent ones stand for them.
    if let Some(sobol) = sobol
        && *sobol != is_sobol
        && !(is_sobol && inexact(&(target.supports)(feature)))
    {
        let word = |sobol: bool| if sobol { "a Sobol sequence" } else { "independent" };
        found.differs(format!("the samples are {} instead of {}", word(*sobol), word(is_sobol)));
    }
}

fn filter(asked: &Asked<'_>, target: &Target, reading: &Reading, found: &mut Found) {
    let wanted = &asked.scene.film.filter;
    let (kind, cut) = match wanted {
        Filter::Box { radius } if *radius == 0.5 => (Feature::PixelFilter, false),
        Filter::Box { radius: _ } => (Feature::BoxFilter, false),
        // Where a target cuts its own, the ledger says so.
        Filter::Gaussian { stddev: _, radius: _ } => {
            (Feature::GaussianFilter, inexact(&(target.supports)(Feature::CutGaussianFilter)))
        }
    };
    // The pixel stands for what a target does not have.
    if unsupported(&(target.supports)(kind)) {
        return;
    }
    let near = |said: f64, wanted: f64| !off(said, wanted, TEXT * wanted);
    let same = match (wanted, &reading.filter) {
        (Filter::Box { radius }, Some(Filter::Box { radius: said })) => near(*said, *radius),
        (Filter::Gaussian { stddev, radius }, Some(Filter::Gaussian { stddev: deviation, radius: at })) => {
            near(*deviation, *stddev) && (cut || near(*at, *radius))
        }
        _ => false,
    };
    if !same {
        let shown = reading.filter.as_ref().map_or_else(|| "none".to_owned(), |filter| format!("{filter:?}"));
        found.differs(format!("the filter is {shown} instead of {wanted:?}"));
    }
}

fn depth(asked: &Asked<'_>, target: &Target, reading: &Reading, found: &mut Found) {
    let integrator = &asked.scene.integrator;
    let wanted = integrator.max_depth().min(reading.most.unwrap_or(u32::MAX));
    // Some targets have no paths of one segment, and none has photons for them.
    let photons = match integrator {
        Integrator::PhotonMap { max_depth: _ } => !unsupported(&(target.supports)(Feature::PhotonMap)),
        Integrator::Path { max_depth: _ }
        | Integrator::Bidirectional { max_depth: _ }
        | Integrator::LightTracing { max_depth: _ }
        | Integrator::Metropolis { max_depth: _ } => false,
    };
    let raised = wanted < 2 && (photons || inexact(&(target.supports)(Feature::EmissionOnly)));
    match reading.max_depth {
        Some(depth) if depth == wanted || (raised && depth == 2) => {}
        Some(depth) => found.differs(format!("paths have {depth} segments instead of {wanted}")),
        None => found.differs("the files give no path depth"),
    }
}

fn far(a: Vec3, b: Vec3, by: f64) -> bool {
    off(length(sub(a, b)), 0.0, by)
}

fn view_differs(asked: &Asked<'_>, view: &View, found: &mut Found) {
    let camera = &asked.scene.cameras[asked.camera];
    let Camera { name: _, eye, target: _, up: _, fov_x, near: _, far: _ } = camera;
    let View { eye: at, right, up, forward, fov_x: across, fov_y: along, shift } = view;
    if far(*at, *eye, asked.slack()) {
        found.differs(format!("the camera stands at {at:?} instead of {eye:?}"));
    }
    if let Some(axes) = camera.axes() {
        let Axes { right: to_right, up: to_top, forward: ahead } = axes;
        if far(*forward, ahead, TEXT) {
            found.differs(format!("the camera looks along {forward:?} instead of {ahead:?}"));
        } else if far(*right, to_right, TEXT) || far(*up, to_top, TEXT) {
            let mirrored = !far(*right, to_right.map(|x| -x), TEXT) && !far(*up, to_top, TEXT);
            let how = if mirrored { "the image is mirrored" } else { "the image is turned" };
            found.differs(format!("{how}: {right:?} is right and {up:?} up, instead of {to_right:?} and {to_top:?}"));
        }
    }
    let wrong = |said: f64, wanted: f64| off(said, wanted, TEXT * wanted);
    if wrong(*across, *fov_x) {
        found.differs(format!("the angle of view `fov_x` is {across} degrees instead of {fov_x}"));
    }
    let wanted = camera::fov_y(*fov_x, &asked.scene.film);
    if wrong(*along, wanted) {
        found.differs(format!("the vertical angle of view is {along} degrees instead of {wanted}"));
    }
    if shift.iter().any(|pixels| off(*pixels, 0.0, PIXEL)) {
        found.differs(format!("the image is shifted by {shift:?} pixels"));
    }
}

/// The feature of a light.
fn feature(kind: &LightKind) -> Feature {
    match kind {
        LightKind::Environment { radiance: ColorOrTexture::Color(_), tint: _, turn: _ } => Feature::Environment,
        LightKind::Environment { radiance: ColorOrTexture::Texture(_), tint: _, turn: _ } => Feature::EnvironmentImage,
        LightKind::Point { position: _, intensity: _ } => Feature::PointLight,
        LightKind::Spot { position: _, target: _, intensity: _, angle: _, inner: _ } => Feature::SpotLight,
        LightKind::Directional { direction: _, irradiance: _ } => Feature::DirectionalLight,
    }
}

fn lights(asked: &Asked<'_>, target: &Target, said: &[Light], found: &mut Found) {
    let wanted: Vec<(&LightSource, Support)> =
        asked.scene.lights.values().map(|light| (light, (target.supports)(feature(&light.kind)))).collect();
    // A light that a target cannot say is left out, or something constant stands for it.
    let spare = wanted.len().saturating_sub(said.len());
    let dropped: Vec<bool> = {
        let mut left = spare;
        let drop = |(_, support): &(&LightSource, Support)| {
            let drop = left > 0 && unsupported(support);
            left -= usize::from(drop);
            drop
        };
        wanted.iter().map(drop).collect()
    };
    let kept: Vec<_> = wanted.into_iter().zip(dropped).filter(|(_, dropped)| !dropped).map(|(one, _)| one).collect();
    if kept.len() != said.len() {
        found.differs(format!("there are {} lights without a surface instead of {}", said.len(), kept.len()));
        return;
    }
    for ((LightSource { name, kind }, support), light) in kept.iter().zip(said) {
        // An image in a format that the target cannot read is as good as one that it has no place for.
        let image = kind.texture().into_iter().flat_map(|texture| of_texture(&asked.scene.textures[texture]));
        let stands_in =
            unsupported(support) || image.into_iter().any(|feature| unsupported(&(target.supports)(feature)));
        if let Some(what) = light_differs(asked, target, kind, light, stands_in) {
            found.differs(format!("the light `{name}` {what}"));
        }
    }
}

fn strength_differs(wanted: Rgb, said: Rgb) -> Option<String> {
    let far = |(a, b): (f64, f64)| off(a, b, TEXT * a.abs().max(b.abs()));
    wanted.into_iter().zip(said).any(far).then(|| format!("has the strength {said:?} instead of {wanted:?}"))
}

fn light_differs(
    asked: &Asked<'_>,
    target: &Target,
    kind: &LightKind,
    light: &Light,
    stands_in: bool,
) -> Option<String> {
    let place = |wanted: &Vec3, said: &Vec3| {
        far(*wanted, *said, asked.slack()).then(|| format!("is at {said:?} instead of {wanted:?}"))
    };
    let axis = |wanted: Vec3, said: &Vec3| {
        let wanted = normalized(wanted)?;
        far(wanted, *said, TEXT).then(|| format!("goes along {said:?} instead of {wanted:?}"))
    };
    match (kind, light) {
        (LightKind::Environment { radiance, tint, turn }, Light::Environment { radiance: said, turn: to }) => {
            let off = turn.rows.as_flattened().iter().zip(to.rows.as_flattened()).any(|(a, b)| off(*a, *b, TEXT));
            let purpose = Use::Sky(tint.rgb());
            super::walk::paint_differs(asked, radiance, said, stands_in, (target.images, purpose))
                .or_else(|| off.then(|| format!("is turned by {to:?} instead of {turn:?}")))
        }
        (LightKind::Point { position, intensity }, Light::Point { position: at, intensity: said }) => {
            place(position, at).or_else(|| strength_differs(intensity.rgb(), *said))
        }
        (
            LightKind::Spot { position, target, intensity, angle, inner },
            Light::Spot { position: at, direction, intensity: said, angle: cut, inner: full },
        ) => {
            let edge = if *inner >= angle * (1.0 - EDGE) { angle * EDGE } else { 0.0 };
            let cone = off(*angle, *cut, ANGLE) || off(*inner, *full, ANGLE + edge);
            place(position, at)
                .or_else(|| axis(sub(*target, *position), direction))
                .or_else(|| cone.then(|| format!("has the angles {cut} and {full} instead of {angle} and {inner}")))
                .or_else(|| strength_differs(intensity.rgb(), *said))
        }
        (LightKind::Directional { direction, irradiance }, Light::Directional { direction: to, irradiance: said }) => {
            axis(*direction, to).or_else(|| strength_differs(irradiance.rgb(), *said))
        }
        (
            LightKind::Environment { radiance: _, tint: _, turn: _ }
            | LightKind::Point { position: _, intensity: _ }
            | LightKind::Spot { position: _, target: _, intensity: _, angle: _, inner: _ }
            | LightKind::Directional { direction: _, irradiance: _ },
            _,
        ) => Some(format!("is `{}` instead of `{}`", light.word(), kind.word())),
    }
}
