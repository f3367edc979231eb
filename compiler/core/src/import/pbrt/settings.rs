//! What is said before the world: camera, film, filter, sampler, algorithm.

use super::dialect::Dialect;
use super::params::Params;
use super::world::{World, inverse};
use crate::import::build::Settings;
use crate::import::reader::Fate;
use crate::import::reader::shown;
use crate::ir::{Affine, Camera, Film, Filter, Integrator, Sampler, Vec3, cross, dot, length, normalized};

/// What a file has said so far, with the defaults of its version.
pub struct Wanted {
    /// The camera and the transform at its place: known once the film is.
    pub camera: Option<(Params, Affine)>,
    film: Film,
    integrator: Integrator,
    sampler: Sampler,
    /// The algorithm's own number of samples (`mlt`, `sppm`).
    passes: Option<u32>,
}

/// v3's and v4's own depth, `maxdepth` 5, which counts bounces between segments.
const DEPTH: u32 = 6;

/// The coordinates that a Scene has.
pub const FARTHEST: f64 = 1e30;

impl Wanted {
    /// The defaults of a version (`RenderOptions` of `api.cpp`; `BasicSceneBuilder` of v4).
    pub fn new(dialect: Dialect) -> Self {
        let (width, height) = if dialect == Dialect::V4 { (1280, 720) } else { (640, 480) };
        let filter = match dialect {
            Dialect::Old | Dialect::V3 => Filter::Box { radius: 0.5 },
            Dialect::V4 => Filter::Gaussian { stddev: 0.5, radius: 1.5 },
        };
        let samples = if dialect == Dialect::Old { 4 } else { 16 };
        Self {
            camera: None,
            film: Film { width, height, filter },
            integrator: Integrator::Path { max_depth: if dialect == Dialect::Old { 2 } else { DEPTH } },
            sampler: Sampler::Independent { samples, seed: 0 },
            passes: None,
        }
    }

    /// What the scene is rendered by.
    pub fn settings(self) -> Settings {
        let sampler = match (self.sampler, self.passes) {
            (Sampler::Independent { samples: _, seed }, Some(samples)) => Sampler::Independent { samples, seed },
            (Sampler::Sobol { samples: _, seed }, Some(samples)) => Sampler::Sobol { samples, seed },
            (sampler, None) => sampler,
        };
        Settings { film: self.film, integrator: self.integrator, sampler }
    }
}

impl World<'_, '_> {
    /// The camera, and with it whether the world is mirrored.
    pub fn place_camera(&mut self) {
        let Some((params, map)) = self.wanted.camera.take() else { return };
        let camera = self.camera(&params, &map);
        params.finish(self.reader);
        if let Some(camera) = camera {
            self.to.camera(camera, &params.span.into());
        }
    }

    fn camera(&mut self, params: &Params, map: &Affine) -> Option<Camera> {
        let Some(own) = inverse(map) else {
            self.dropped(params.span, "a camera is left out: its transform has no inverse");
            return None;
        };
        // PBRT's camera looks along z with x to the right: to see the Scene as it does, the world must be seen mirrored, or be mirrored.
        if own.determinant() > 0.0 {
            self.outer = Affine::scaling([-1.0, 1.0, 1.0]);
            let message = "the world is left-handed: its x is mirrored, so that the image is the same";
            self.reader.lost(Fate::Baked, params.span, message);
        }
        let own = own.then(&self.outer);
        let film = &self.wanted.film;
        let of_film = f64::from(film.width) / f64::from(film.height);
        let aspect = params.float("frameaspectratio", self.reader).filter(|aspect| *aspect > 0.0).unwrap_or(of_film);
        // The shorter axis spans -1 to 1 (`CreatePerspectiveCamera`).
        let (across, up) = if aspect > 1.0 { (aspect, 1.0) } else { (1.0, 1.0 / aspect) };
        let mut window = [-across, across, -up, up];
        if let Some(given) = params.numbers("screenwindow", self.reader) {
            match given {
                [a, b, c, d] if a < b && c < d => window = [*a, *b, *c, *d],
                _ => self.dropped(params.span_of("screenwindow"), "`screenwindow` is left out: it is no window"),
            }
        }
        let (wide, high) = (window[1] - window[0], window[3] - window[2]);
        if ((wide / high) / of_film - 1.0).abs() > 1e-3 {
            let message = "pixels that are not square are: the image is as high as its pixels make it";
            self.dropped(params.span, message);
        }
        let moved = (window[0] + window[1]).abs() / wide > 1e-4 || (window[2] + window[3]).abs() / high > 1e-4;
        if moved {
            let message = "a screen window beside the axis is moved: the axis meets the middle of the image";
            self.dropped(params.span_of("screenwindow"), message);
        }
        let fov = match params.kind.as_str() {
            "perspective" => self.field_of_view(params),
            "realistic" | "orthographic" | "environment" | "spherical" => {
                let message = format!("the camera `{}` is read as a pinhole of 45 degrees", params.kind);
                self.dropped(params.span, message);
                params.pass_all();
                45.0
            }
            other => {
                let message =
                    format!("the camera `{}` is not known: it is read as a pinhole of 45 degrees", shown(other));
                self.dropped(params.span, message);
                params.pass_all();
                45.0
            }
        };
        let tangent = libm::tan((fov / 2.0).to_radians()) * wide / 2.0;
        let fov_x = (2.0 * libm::atan(tangent)).to_degrees();
        if !(1e-6..=179.999).contains(&fov_x) {
            self.dropped(params.span, format!("an image of {fov_x} degrees is read as one of 90"));
        }
        let fov_x = if (1e-6..=179.999).contains(&fov_x) { fov_x } else { 90.0 };
        if params.float("lensradius", self.reader).is_some_and(|radius| radius > 0.0) {
            let message = "the aperture of a camera is left out: all is in focus";
            self.dropped(params.span_of("lensradius"), message);
        }
        params.pass(&["focaldistance", "shutteropen", "shutterclose", "screenwindow", "frameaspectratio"]);
        let column = |at: usize| -> Vec3 { [0, 1, 2].map(|row: usize| own.rows[row][at]) };
        let (x, up, forward) = (column(0), column(1), column(2));
        let ahead = normalized(forward)?;
        let sheared = |a: Vec3, b: Vec3| dot(a, b).abs() > 1e-4 * length(a) * length(b);
        let uneven = |a: Vec3, b: Vec3| (length(a) / length(b) - 1.0).abs() > 1e-4;
        if sheared(x, up) || sheared(x, forward) || sheared(up, forward) || uneven(x, up) || uneven(x, forward) {
            self.dropped(params.span, "the image of a camera that is scaled unevenly is not");
        }
        let eye = column(3);
        // Far from the origin a step of 1 may be none.
        let step = eye.iter().fold(1.0, |most: f64, x| most.max(x.abs() * 1e-3));
        let target = [0, 1, 2].map(|axis: usize| eye[axis] + ahead[axis] * step);
        // As it is written, where nothing but a mirror stands before it.
        let [eye, target, up] = match self.look {
            Some((row, before, behind)) if behind == *map && mirrors(&before) && apart(&row) => {
                let [ex, ey, ez, tx, ty, tz, ux, uy, uz] = row;
                let outer = self.outer;
                [outer.point([ex, ey, ez]), outer.point([tx, ty, tz]), outer.vector([ux, uy, uz])]
            }
            _ => [eye, target, up],
        };
        if ![eye, target, up].iter().flatten().all(|x| x.abs() <= FARTHEST) || normalized(cross(ahead, up)).is_none() {
            self.dropped(
                params.span,
                "a camera is left out: its transform has no inverse, or it is farther away than 1e30",
            );
            return None;
        }
        let near = params.float("hither", self.reader).filter(|near| *near > 1e-30 && *near < FARTHEST);
        let far = params.float("yon", self.reader).filter(|far| *far > near.unwrap_or(1e-30) && *far < FARTHEST);
        Some(Camera { name: None, eye, target, up, fov_x, near, far })
    }

    fn field_of_view(&mut self, params: &Params) -> f64 {
        let half = params.float("halffov", self.reader).map(|half| 2.0 * half);
        let fov = half.or(params.float("fov", self.reader)).unwrap_or(90.0);
        if fov > 0.0 && fov < 180.0 {
            return fov;
        }
        let message = format!("a field of view of {fov} degrees is read as one of 90");
        self.dropped(params.span_of("fov"), message);
        90.0
    }

    /// `Film`.
    pub fn film(&mut self, params: &Params) {
        let film = (self.wanted.film.width, self.wanted.film.height);
        let side = |name: &str, default: u32, world: &mut Self| {
            let value = params.count(name, world.reader).unwrap_or(default);
            if (1..=65_536).contains(&value) {
                return value;
            }
            world.dropped(params.span_of(name), format!("`{name}` is not between 1 and 65536: {default} is taken"));
            default
        };
        self.wanted.film.width = side("xresolution", film.0, self);
        self.wanted.film.height = side("yresolution", film.1, self);
        let whole = |bounds: &[f64]| bounds == [0.0, 1.0, 0.0, 1.0];
        for name in ["cropwindow", "pixelbounds"] {
            if params.numbers(name, self.reader).is_some_and(|bounds| !whole(bounds)) {
                self.dropped(params.span_of(name), "a crop is left out: the whole image is rendered");
            }
        }
        for name in ["maxsampleluminance", "maxcomponentvalue"] {
            if params.float(name, self.reader).is_some_and(|most| most.is_finite() && most < 1e30) {
                self.near(params.span_of(name), format!("`{name}` is left out: bright samples are not cut"));
            }
        }
        // v4's sensor: `imagingRatio` is exposure time * iso / 100.
        let iso = params.float("iso", self.reader).unwrap_or(100.0);
        let time = params.float("exposuretime", self.reader).unwrap_or(1.0);
        if params.string("sensor", self.reader).is_some_and(|sensor| sensor != "cie1931") {
            let message = "the sensor of a film is left out: its colors are those of the scene";
            self.dropped(params.span_of("sensor"), message);
        }
        let scale = params.float("scale", self.reader).unwrap_or(1.0) * iso * time / 100.0;
        let name = ["scale", "iso"].into_iter().find(|name| params.has(name)).unwrap_or("exposuretime");
        self.exposure = 1.0;
        if !(1e-12..=1e12).contains(&scale) {
            let message = format!("a film that multiplies light by {scale} is read as one that does not");
            self.dropped(params.span_of(name), message);
        } else if (scale - 1.0).abs() > 1e-6 {
            self.exposure = scale;
            let message = format!("the film multiplies light by {scale}: the lights of the scene are as much brighter");
            self.reader.lost(Fate::Baked, params.span_of(name), message);
        }
        if params.float("whitebalance", self.reader).is_some_and(|kelvin| kelvin != 0.0) {
            self.dropped(params.span_of("whitebalance"), "`whitebalance` is left out: colors are those of the scene");
        }
        // What becomes of the image once it is rendered.
        params.pass(&["filename", "diagonal", "savefp16", "display", "premultiplyalpha", "coordinatesystem", "gamma"]);
        params.pass(&["xwidth", "ywidth", "writefrequency", "bloomradius", "bloomweight", "maxdisplayY", "tonemap"]);
    }

    /// `PixelFilter`. Those that the Scene does not have become the Gaussian of equal variance.
    pub fn filter(&mut self, params: &Params) {
        let of = |names: [&str; 2], default: f64, world: &mut Self| {
            let given = params.float(names[0], world.reader).or_else(|| params.float(names[1], world.reader));
            given.filter(|radius| *radius > 0.0).unwrap_or(default)
        };
        let v4 = self.dialect == Dialect::V4;
        let default = match params.kind.as_str() {
            "box" => 0.5,
            "gaussian" if v4 => 1.5,
            "sinc" => 4.0,
            _ => 2.0,
        };
        let radius = of(["xradius", "xwidth"], default, self);
        let other = of(["yradius", "ywidth"], default, self);
        if radius != other {
            let message = format!("a filter that is wider along one axis has the radius {radius} along both");
            self.dropped(params.span, message);
        }
        let known = match params.kind.as_str() {
            "box" => {
                self.wanted.film.filter = Filter::Box { radius };
                return;
            }
            "gaussian" => {
                let sigma = params.float("sigma", self.reader).filter(|sigma| *sigma > 0.0);
                let alpha = params.float("alpha", self.reader).filter(|alpha| *alpha > 0.0);
                // exp(-alpha x^2), alpha = 1 / (2 stddev^2); v3's default is 2.
                let stddev = match (sigma, alpha) {
                    (Some(sigma), _) => sigma,
                    (None, Some(alpha)) => (1.0 / (2.0 * alpha)).sqrt(),
                    (None, None) => 0.5,
                };
                self.wanted.film.filter = Filter::Gaussian { stddev, radius };
                return;
            }
            "triangle" | "mitchell" | "sinc" => true,
            _ => false,
        };
        // A triangle from -r to r has a variance of r^2 / 6; the others sharpen, and a pixel has one of 1 / 12.
        let variance = if params.kind == "triangle" { radius * radius / 6.0 } else { 1.0 / 12.0 };
        let stddev = variance.sqrt().max(1e-3);
        params.pass(&["B", "C", "tau"]);
        let fate = if known { Fate::Approximated } else { Fate::Dropped };
        let kind = shown(&params.kind);
        let message =
            format!("the filter `{kind}` is read as a Gaussian with a standard deviation of {stddev:.3} pixels");
        self.reader.lost(fate, params.span, message);
        self.wanted.film.filter = Filter::Gaussian { stddev, radius: 4.0 * stddev };
    }

    /// `Sampler`.
    pub fn sampler(&mut self, params: &Params) {
        let kind = params.kind.as_str();
        let v4 = self.dialect == Dialect::V4;
        let default = match kind {
            "random" | "independent" | "lowdiscrepancy" | "bestcandidate" => 4,
            _ => 16,
        };
        let count = |name: &str, world: &mut Self| params.count(name, world.reader).filter(|count| *count > 0);
        let mut samples = count("pixelsamples", self).unwrap_or(default);
        if matches!(kind, "stratified" | "random") && !params.has("pixelsamples") {
            let side = if self.dialect == Dialect::Old { 2 } else { 4 };
            if kind == "stratified" || params.has("xsamples") {
                let (x, y) = (count("xsamples", self).unwrap_or(side), count("ysamples", self).unwrap_or(side));
                samples = x.saturating_mul(y);
            }
        }
        let seed = if v4 { params.count("seed", self.reader).unwrap_or(0) } else { 0 };
        self.wanted.sampler = match kind {
            "sobol" | "zsobol" | "paddedsobol" => Sampler::Sobol { samples, seed },
            "random" | "independent" => Sampler::Independent { samples, seed },
            other => {
                let message =
                    format!("the sampler `{}` is read as independent samples: the noise is another", shown(other));
                self.reader.lost(Fate::Noise, params.span, message);
                Sampler::Independent { samples, seed }
            }
        };
        params.pass(&[
            "dimensions",
            "jitter",
            "randomization",
            "xsamples",
            "ysamples",
            "samplepixelcenter",
            "minsamples",
        ]);
        params.pass(&["maxsamples", "method", "adaptivemethod"]);
    }

    /// `Integrator`, `SurfaceIntegrator`: what maxdepth counts lies between segments.
    pub fn integrator(&mut self, params: &Params) {
        let depth = match params.float("maxdepth", self.reader) {
            Some(depth) if depth >= 0.0 => (depth.min(1e6) as u32) + 1,
            Some(_) => {
                let message = "paths without an end have at most 1000 segments";
                self.near(params.span_of("maxdepth"), message);
                1000
            }
            None => DEPTH,
        };
        let kind = params.kind.as_str();
        let max_depth = depth;
        self.wanted.integrator = match kind {
            "path" | "volpath" | "simplepath" | "simplevolpath" => Integrator::Path { max_depth },
            "bdpt" => Integrator::Bidirectional { max_depth },
            "lightpath" => Integrator::LightTracing { max_depth },
            "mlt" => {
                self.wanted.passes = Some(params.count("mutationsperpixel", self.reader).unwrap_or(100).max(1));
                Integrator::Metropolis { max_depth }
            }
            "sppm" => {
                let passes = params.count("iterations", self.reader).or(params.count("numiterations", self.reader));
                if self.dialect != Dialect::V4 || passes.is_some() {
                    self.wanted.passes = Some(passes.unwrap_or(64).max(1));
                }
                Integrator::PhotonMap { max_depth }
            }
            "directlighting" | "whitted" => {
                let message = format!(
                    "`{kind}` is read as paths of two segments: light that comes by way of mirrors and glass is left out"
                );
                self.near(params.span, message);
                Integrator::Path { max_depth: 2 }
            }
            other => {
                let message = format!("the algorithm `{}` is read as path tracing", shown(other));
                self.near(params.span, message);
                Integrator::Path { max_depth }
            }
        };
        if params.boolean("regularize", self.reader) == Some(true) {
            let message = "`regularize` is left out: materials are as rough as they are";
            self.near(params.span_of("regularize"), message);
        }
        if params.numbers("pixelbounds", self.reader).is_some() {
            self.dropped(params.span_of("pixelbounds"), "a crop is left out: the whole image is rendered");
        }
        // How it goes about it: noise and time.
        params.pass_all();
    }

    /// v2's `Renderer`.
    pub fn renderer(&mut self, params: &Params) {
        match params.kind.as_str() {
            "sampler" => {}
            "metropolis" => {
                let max_depth = params.count("maxdepth", self.reader).unwrap_or(7).min(1_000_000) + 1;
                self.wanted.integrator = Integrator::Metropolis { max_depth };
            }
            other => {
                let message = format!("the renderer `{}` is left out: the scene is rendered as usual", shown(other));
                self.dropped(params.span, message);
            }
        }
        params.pass_all();
    }

    /// v4's `Option`.
    pub fn options(&mut self, params: &Params) {
        params.pass(&["seed", "msereferenceimage", "msereferenceout", "rendercoordsys", "disablepixeljitter"]);
        params.pass(&["disabletexturefiltering", "disablewavelengthjitter", "displacementedgescale", "pixelstats"]);
        if params.boolean("forcediffuse", self.reader) == Some(true) {
            let message = "`forcediffuse` is left out: materials are what they are";
            self.dropped(params.span_of("forcediffuse"), message);
        }
    }
}

/// Whether the up of a `LookAt` is far enough from its axis to be said again.
fn apart([ex, ey, ez, tx, ty, tz, ux, uy, uz]: &[f64; 9]) -> bool {
    let (ahead, up) = (normalized([tx - ex, ty - ey, tz - ez]), normalized([*ux, *uy, *uz]));
    ahead.zip(up).is_some_and(|(ahead, up)| length(cross(ahead, up)) > 1e-4)
}

/// Whether a map is nothing, or a mirror of x.
fn mirrors(map: &Affine) -> bool {
    *map == Affine::IDENTITY || *map == Affine::scaling([-1.0, 1.0, 1.0])
}
