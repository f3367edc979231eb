//! Cameras, and the settings that ltsc writes into the `extras` of a scene.

use super::at;
use crate::files::VPath;
use crate::import::Builder;
use crate::import::build::Settings;
use crate::import::reader::{Fate, Reader};
use crate::ir::{Affine, Camera, Film, Filter, Integrator, Sampler, cross, dot, normalized};
use crate::mesh::file::FileError;
use crate::mesh::file::gltf::document::{Document, Item};

/// The larger side of an image whose size the file leaves open, in pixels.
const SIDE: f64 = 512.0;
/// What has no angle, or one that no camera has, in radians.
const ANGLE: f64 = std::f64::consts::FRAC_PI_4;
/// Farther away nothing may be.
const FARTHEST: f64 = 1e30;

/// Reads film, algorithm and sampling where the file has them, and says whether it has the size of the image.
pub fn settings(document: &Document<'_>, path: &VPath, to: &mut Settings, reader: &mut Reader<'_>) -> bool {
    let scenes = document.list("scenes").unwrap_or_default();
    let chosen = document.whole().count("scene").unwrap_or(0);
    let Some(extras) = scenes.get(chosen).and_then(|scene| scene.inner("extras")) else { return false };
    let side = |film: Item<'_>, key: &str| film.count(key).and_then(|size| u32::try_from(size).ok()).filter(|x| *x > 0);
    let Some(film) = extras.inner("film") else { return false };
    let (Some(width), Some(height)) = (side(film, "width"), side(film, "height")) else { return false };
    if u64::from(width) * u64::from(height) > reader.limits().pixels {
        let message = "the size of the image is left out: it has more pixels than are allowed";
        reader.lost(Fate::Dropped, at(path, format!("/scenes/{chosen}/extras/film")), message);
        return false;
    }
    let filter = film.inner("filter").and_then(|filter| {
        let positive = |key: &str| filter.number(key).filter(|x| *x > 0.0 && *x <= 1e3);
        match filter.text("type")? {
            "box" => Some(Filter::Box { radius: positive("radius")? }),
            "gaussian" => Some(Filter::Gaussian { stddev: positive("stddev")?, radius: positive("radius")? }),
            _ => None,
        }
    });
    to.film = Film { width, height, filter: filter.unwrap_or(Filter::Box { radius: 0.5 }) };
    let number = |item: Option<Item<'_>>, key: &str| item.and_then(|item| u32::try_from(item.count(key)?).ok());
    let integrator = extras.inner("integrator");
    let max_depth = number(integrator, "max_depth").unwrap_or(to.integrator.max_depth()).max(1);
    to.integrator = match integrator.and_then(|integrator| integrator.text("type")) {
        Some("bidirectional") => Integrator::Bidirectional { max_depth },
        Some("light_tracing") => Integrator::LightTracing { max_depth },
        Some("metropolis") => Integrator::Metropolis { max_depth },
        Some("photon_map") => Integrator::PhotonMap { max_depth },
        _ => Integrator::Path { max_depth },
    };
    let sampler = extras.inner("sampler");
    if let Some(samples) = number(sampler, "samples").filter(|samples| *samples > 0) {
        let seed = number(sampler, "seed").unwrap_or(0);
        to.sampler = match sampler.and_then(|sampler| sampler.text("type")) {
            Some("sobol") => Sampler::Sobol { samples, seed },
            _ => Sampler::Independent { samples, seed },
        };
    }
    true
}

/// The cameras at these nodes. Where the size of the image is not known (`sized`), the first one's ratio gives it.
///
/// # Errors
/// A list of cameras that is none.
pub fn cameras(
    document: &Document<'_>,
    nodes: &[(Item<'_>, Affine)],
    path: &VPath,
    (film, mut sized): (&mut Film, bool),
    reader: &mut Reader<'_>,
    to: &mut Builder,
) -> Result<(), FileError> {
    let cameras = document.list("cameras")?;
    for (node, map) in nodes.iter().filter(|(node, _)| node.get("camera").is_some()) {
        let here = at(path, node.place());
        let Some(camera) = node.count("camera").and_then(|at| cameras.get(at).copied()) else {
            reader.lost(Fate::Dropped, here, "a camera is left out: its index points to nothing");
            continue;
        };
        let there = || at(path, camera.place());
        let lens = camera.inner("perspective");
        if lens.is_none() {
            let message = "a camera that is not in perspective is read as a pinhole of 45 degrees";
            reader.lost(Fate::Dropped, there(), message);
        }
        let number = |key: &str| lens.and_then(|lens| lens.number(key));
        let ratio = number("aspectRatio").filter(|ratio| (1e-3..=1e3).contains(ratio));
        if !std::mem::replace(&mut sized, true) {
            let wide = ratio.unwrap_or(1.0);
            let pixels = |share: f64| (SIDE * share.min(1.0)).round().max(1.0) as u32;
            (film.width, film.height) = (pixels(wide), pixels(1.0 / wide));
        }
        let wide = f64::from(film.width) / f64::from(film.height);
        if ratio.is_some_and(|ratio| (ratio / wide - 1.0).abs() > 0.01) {
            let message = "a camera has another ratio of width to height than the image: what it shows from top to bottom is kept";
            reader.lost(Fate::Approximated, there(), message);
        }
        let yfov = number("yfov").filter(|angle| *angle > 1e-6 && *angle < std::f64::consts::PI - 1e-6);
        if yfov.is_none() && lens.is_some() {
            reader.lost(
                Fate::Dropped,
                there(),
                "a camera without an angle of view that can be is read as one of 45 degrees",
            );
        }
        let fov_x = (2.0 * libm::atan(libm::tan(yfov.unwrap_or(ANGLE) / 2.0) * wide)).to_degrees();
        let column = |at: usize| map.rows.map(|row| row[at]);
        let axes = [column(0), column(1), column(2).map(|x| -x)].map(normalized);
        let eye = column(3);
        let ([Some(right), Some(up), Some(ahead)], true) = (axes, eye.iter().all(|x| x.abs() < FARTHEST)) else {
            reader.lost(Fate::Dropped, here, "a camera is left out: its node has no axes, or is beyond 1e30");
            continue;
        };
        if normalized(cross(ahead, up)).is_none() {
            reader.lost(Fate::Dropped, here, "a camera is left out: its node has no axes, or is beyond 1e30");
            continue;
        }
        let skewed = dot(right, up).abs().max(dot(up, ahead).abs()).max(dot(right, ahead).abs()) > 1e-4;
        if skewed || map.determinant() < 0.0 {
            reader.lost(Fate::Dropped, here.clone(), "the image of a camera that its node mirrors or shears is not");
        }
        // Far from the origin a step of 1 may be none.
        let step = eye.iter().fold(1.0, |most: f64, x| most.max(x.abs() * 1e-3));
        let target = [0, 1, 2].map(|axis: usize| eye[axis] + ahead[axis] * step);
        let near = number("znear").filter(|near| *near > 1e-30 && *near < FARTHEST);
        let far = number("zfar").filter(|far| *far > near.unwrap_or(1e-30) && *far < FARTHEST);
        let name = [node.text("name"), camera.text("name")].into_iter().flatten().find(|name| !name.is_empty());
        to.camera(Camera { name: name.map(str::to_owned), eye, target, up, fov_x, near, far }, &here);
    }
    Ok(())
}
