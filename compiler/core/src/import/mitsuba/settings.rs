//! Cameras, film, sampler and integrator.

use super::plugin::Plugin;
use super::surface::World;
use crate::diag::Origin;
use crate::import::Builder;
use crate::import::build::Settings;
use crate::import::reader::shown;
use crate::import::reader::{Fate, Reader};
use crate::ir::{Affine, Camera, Film, Filter, Integrator, Sampler, Vec3, length, normalized};

/// The depth that stands for paths without an end.
const ENDLESS: u32 = 1000;

/// A camera, and the settings that stand in it.
pub fn sensor<'e>(
    plugin: Plugin<'e>,
    world: &World<'e>,
    settings: &mut Settings,
    reader: &mut Reader<'_>,
    to: &mut Builder,
) {
    if let Some(film) = nested(plugin, "film", world, reader) {
        self::film(film, &mut settings.film, reader);
    } else {
        (settings.film.width, settings.film.height) = (768, 576);
        settings.film.filter = Filter::Gaussian { stddev: 0.5, radius: 2.0 };
    }
    if let Some(sampler) = nested(plugin, "sampler", world, reader) {
        settings.sampler = self::sampler(sampler, reader);
    }
    let at = Origin::from(plugin.span());
    let map = plugin.transform("to_world", reader);
    let camera = match plugin.kind() {
        "perspective" | "thinlens" | "perspective_rdist" | "irradiancemeter" => {
            perspective(plugin, &map, &settings.film, reader)
        }
        other => {
            let message = format!("the camera `{}` is left out: it is not read", shown(other));
            reader.lost(Fate::Dropped, plugin.span(), message);
            plugin.element.children.iter().for_each(|child| child.used.set(true));
            None
        }
    };
    plugin.pass(&["shutter_open", "shutter_close", "srf"]);
    for medium in plugin.element.children.iter().filter(|child| matches!(child.tag.as_str(), "ref" | "medium")) {
        if !medium.used.replace(true) {
            reader.lost(Fate::Dropped, medium.span, "a medium is left out: light travels through nothing");
        }
    }
    plugin.finish(reader);
    if let Some(camera) = camera {
        to.camera(camera, &at);
    }
}

/// A plugin of a kind that stands in another one, or that it refers to.
fn nested<'e>(plugin: Plugin<'e>, tag: &'static str, world: &World<'e>, reader: &mut Reader<'_>) -> Option<Plugin<'e>> {
    if let Some(inner) = plugin.inner(tag).next() {
        return Some(inner);
    }
    let references = plugin.element.children.iter().filter(|child| child.tag == "ref");
    let known =
        |reference: &&super::tree::Element| world.ids.get(reference.word("id")).is_some_and(|found| found.tag == tag);
    references.filter(known).find_map(|reference| world.referred(reference, reader))
}

fn perspective(plugin: Plugin<'_>, map: &Affine, film: &Film, reader: &mut Reader<'_>) -> Option<Camera> {
    let aspect = f64::from(film.width) / f64::from(film.height);
    let axis = plugin.string("fov_axis").unwrap_or("x");
    let half = |degrees: f64| libm::tan((degrees / 2.0).to_radians());
    let full = |tangent: f64| (2.0 * libm::atan(tangent)).to_degrees();
    let diagonal = |tangent: f64| tangent * aspect / (1.0 + aspect * aspect).sqrt();
    let fov = plugin.float("fov", reader).filter(|fov| *fov > 0.0 && *fov < 180.0);
    let fov_x = match fov {
        Some(fov) => match axis {
            "y" => full(half(fov) * aspect),
            "diagonal" => full(diagonal(half(fov))),
            "smaller" if aspect > 1.0 => full(half(fov) * aspect),
            "larger" if aspect < 1.0 => full(half(fov) * aspect),
            "x" | "smaller" | "larger" => fov,
            other => {
                let message = format!("the axis `{}` of the field of view is not known: x is taken", shown(other));
                reader.lost(Fate::Dropped, plugin.span_of("fov_axis"), message);
                fov
            }
        },
        // The diagonal of film of 36 x 24 mm, as both versions have it.
        None => {
            let written = plugin.string("focal_length").unwrap_or("50mm");
            let millimeters =
                super::plugin::number(written.trim_end_matches("mm")).filter(|x| *x > 0.0).unwrap_or(50.0);
            full(diagonal((36.0_f64 * 36.0 + 24.0 * 24.0).sqrt() / 2.0 / millimeters))
        }
    };
    if plugin.kind() == "thinlens" {
        if plugin.float("aperture_radius", reader).unwrap_or(0.0) > 0.0 {
            let message = "the aperture of a camera is left out: all is in focus";
            reader.lost(Fate::Dropped, plugin.span_of("aperture_radius"), message);
        }
        plugin.pass(&["focus_distance"]);
    }
    plugin.pass(&["focus_distance"]);
    plugin.drop(Fate::Dropped, &["kc"], "the lens does not distort", reader);
    for name in ["principal_point_offset_x", "principal_point_offset_y"] {
        if plugin.float(name, reader).is_some_and(|offset| offset != 0.0) {
            reader.lost(
                Fate::Dropped,
                plugin.span_of(name),
                format!("`{name}` is left out: the axis meets the middle"),
            );
        }
    }
    let column = |at: usize| -> Vec3 { [0, 1, 2].map(|row: usize| map.rows[row][at]) };
    let (x, up, forward) = (column(0), column(1), column(2));
    let (Some(ahead), true) = (normalized(forward), map.is_invertible()) else {
        reader.lost(Fate::Dropped, plugin.span(), "a camera is left out: its transform has no inverse");
        return None;
    };
    if map.determinant() < 0.0 {
        reader.lost(Fate::Dropped, plugin.span_of("to_world"), "the image of a mirroring camera is not mirrored");
    }
    let even = (length(x) / length(up) - 1.0).abs() < 1e-4;
    if !even {
        reader.lost(Fate::Dropped, plugin.span_of("to_world"), "the image of a camera that is scaled unevenly is not");
    }
    let eye = column(3);
    let distance = length(forward);
    let target = [0, 1, 2].map(|axis: usize| eye[axis] + ahead[axis] * distance);
    let near = plugin.float("near_clip", reader).filter(|near| *near > 0.0);
    let far = plugin.float("far_clip", reader).filter(|far| *far > near.unwrap_or(0.0));
    let name = (!plugin.id().is_empty()).then(|| plugin.id().to_owned());
    Some(Camera { name, eye, target, up, fov_x, near, far })
}

fn film(plugin: Plugin<'_>, film: &mut Film, reader: &mut Reader<'_>) {
    let mut side = |name: &str, default: u32| {
        let value = plugin.integer(name, reader).unwrap_or(i64::from(default));
        u32::try_from(value).ok().filter(|side| (1..=65_536).contains(side)).unwrap_or(default)
    };
    (film.width, film.height) = (side("width", 768), side("height", 576));
    for name in ["crop_offset_x", "crop_offset_y", "crop_width", "crop_height"] {
        if plugin.has(name) {
            reader.lost(Fate::Dropped, plugin.span_of(name), "a crop is left out: the whole image is rendered");
            plugin.pass(&[name]);
        }
    }
    // What becomes of the image once it is rendered.
    plugin.pass(&["banner", "pixel_format", "component_format", "file_format", "attach_log", "high_quality_edges"]);
    plugin.pass(&["gamma", "exposure", "tonemap_method", "key", "burn", "sample_border", "compensate", "labels"]);
    plugin.pass(&["metadata", "write_log", "digits", "variable", "size", "filename"]);
    film.filter = plugin.inner("rfilter").next().map_or(Filter::Gaussian { stddev: 0.5, radius: 2.0 }, |filter| {
        let read = self::filter(filter, reader);
        filter.finish(reader);
        read
    });
    plugin.finish(reader);
}

/// The filter; those that the Scene does not have become the Gaussian of equal variance.
fn filter(plugin: Plugin<'_>, reader: &mut Reader<'_>) -> Filter {
    let gaussian = |stddev: f64| Filter::Gaussian { stddev, radius: 4.0 * stddev };
    let (stddev, known) = match plugin.kind() {
        "box" => {
            let radius = plugin.float("radius", reader).filter(|radius| *radius > 0.0).unwrap_or(0.5);
            return Filter::Box { radius };
        }
        "gaussian" => {
            let stddev = plugin.float("stddev", reader).filter(|stddev| *stddev > 0.0).unwrap_or(0.5);
            plugin.pass(&["radius"]);
            return gaussian(stddev);
        }
        // A triangle from -r to r has a variance of r^2 / 6.
        "tent" => (plugin.float("radius", reader).unwrap_or(1.0).max(0.1) / 6.0_f64.sqrt(), true),
        // The other filters sharpen; a pixel has a variance of 1 / 12.
        "mitchell" | "catmullrom" | "lanczos" => ((1.0_f64 / 12.0).sqrt(), true),
        _ => (0.5, false),
    };
    plugin.pass(&["b", "c", "lobes", "radius"]);
    let fate = if known { Fate::Approximated } else { Fate::Dropped };
    let kind = shown(plugin.kind());
    let message = format!("the filter `{kind}` is read as a Gaussian with a standard deviation of {stddev:.3} pixels");
    reader.lost(fate, plugin.span(), message);
    gaussian(stddev)
}

fn sampler(plugin: Plugin<'_>, reader: &mut Reader<'_>) -> Sampler {
    let samples = plugin.integer("sample_count", reader).unwrap_or(4).clamp(1, i64::from(u32::MAX)) as u32;
    let seed = plugin.integer("seed", reader).unwrap_or(0);
    let seed = u32::try_from(seed).unwrap_or(0);
    let sampler = match plugin.kind() {
        "sobol" => Sampler::Sobol { samples, seed },
        "independent" => Sampler::Independent { samples, seed },
        other => {
            let message =
                format!("the sampler `{}` is read as independent samples: the noise is another", shown(other));
            reader.lost(Fate::Noise, plugin.span(), message);
            plugin.pass(&["dimension", "scramble", "jitter"]);
            Sampler::Independent { samples, seed }
        }
    };
    plugin.pass(&["dimension", "scramble"]);
    plugin.finish(reader);
    sampler
}

/// The algorithm; what stands in another one, as for moments of an image, is the one that renders.
pub fn integrator(plugin: Plugin<'_>, depth: usize, reader: &mut Reader<'_>) -> Integrator {
    if let Some(inner) = plugin.inner("integrator").next().filter(|_| depth < 8) {
        reader.lost(Fate::Noise, plugin.span(), format!("`{}` is read as what stands in it", shown(plugin.kind())));
        plugin.element.children.iter().for_each(|child| child.used.set(true));
        return integrator(inner, depth + 1, reader);
    }
    let endless = |reader: &mut Reader<'_>| {
        let message = format!("paths without an end have at most {ENDLESS} segments");
        reader.lost(Fate::Approximated, plugin.span_of("max_depth"), message);
        ENDLESS
    };
    let max_depth = match plugin.integer("max_depth", reader) {
        Some(depth) if depth >= 1 => u32::try_from(depth).unwrap_or(ENDLESS),
        _ => endless(reader),
    };
    let integrator = match plugin.kind() {
        "path" | "volpath" | "volpath_simple" | "volpathmis" | "prb" => Integrator::Path { max_depth },
        "direct" => {
            plugin.pass(&["emitter_samples", "bsdf_samples", "shading_samples"]);
            Integrator::Path { max_depth: 2 }
        }
        "bdpt" => Integrator::Bidirectional { max_depth },
        "ptracer" => Integrator::LightTracing { max_depth },
        "pssmlt" | "mlt" | "erpt" => Integrator::Metropolis { max_depth },
        "sppm" | "ppm" | "photonmapper" => Integrator::PhotonMap { max_depth },
        other => {
            let message = format!("the algorithm `{}` is read as path tracing", shown(other));
            reader.lost(Fate::Approximated, plugin.span(), message);
            plugin.element.children.iter().for_each(|child| child.used.set(true));
            Integrator::Path { max_depth }
        }
    };
    if plugin.boolean("hide_emitters", reader).unwrap_or(false) {
        let message = "`hideEmitters` is left out: lights are seen";
        reader.lost(Fate::Dropped, plugin.span_of("hide_emitters"), message);
    }
    if plugin.boolean("strict_normals", reader).unwrap_or(false) {
        let message = "`strictNormals` is left out: light that meets a smooth surface from behind its faces is counted, \
                       at most 0.3 % of the scenes that it was measured in";
        reader.lost(Fate::Approximated, plugin.span_of("strict_normals"), message);
    }
    // How it goes about it: noise and time.
    for child in plugin.element.children.iter().filter(|child| !child.used.get()) {
        child.used.set(true);
        let name = shown(child.word("name"));
        let message = format!("`{name}` of `{}` is left out: it changes noise and time", shown(plugin.kind()));
        reader.lost(Fate::Noise, child.span, message);
    }
    integrator
}
