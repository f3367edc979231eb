//! Cameras, films, filters, integrators and samplers.

use std::rc::Rc;

use crate::ir::{Film, Filter, Integrator, Sampler};

use super::super::value::{CameraValue, Ty, Value};
use super::{Args, Constructor, Family, Parameter, Problem};

/// The largest side of an image; what the EXR readers of common tools still open.
const LARGEST_SIDE: u32 = 65_536;

/// The parameter of all integrators.
const MAX_DEPTH: &[Parameter] = &[Parameter {
    name: "max_depth",
    ty: Ty::Whole,
    default: None,
    doc: "segments of a path, at least 1; 1 is emission seen directly",
}];

pub(super) const ROWS: &[Constructor] = &[
    Constructor {
        family: Family::Camera,
        name: "perspective",
        summary: "A pinhole camera.",
        params: &[
            Parameter { name: "eye", ty: Ty::Vec3, default: None, doc: "position" },
            Parameter { name: "target", ty: Ty::Vec3, default: None, doc: "the point it looks at" },
            Parameter { name: "up", ty: Ty::Vec3, default: Some("Z"), doc: "the direction that is up in the image" },
            Parameter {
                name: "fov_x",
                ty: Ty::Angle,
                default: Some(""),
                doc: "full angle of view along the image's width; exactly one of `fov_x` and `fov_y`",
            },
            Parameter { name: "fov_y", ty: Ty::Angle, default: Some(""), doc: "full angle of view along its height" },
            Parameter { name: "near", ty: Ty::Number, default: Some(""), doc: "near clipping distance, > 0" },
            Parameter { name: "far", ty: Ty::Number, default: Some(""), doc: "far clipping distance, > near" },
        ],
        positional: 0,
        example: "camera = perspective(eye: (0, -160, 50), target: (0, 0, 50), fov_x: 45deg)",
        build: |args, _| camera(args),
    },
    Constructor {
        family: Family::Film,
        name: "image",
        summary: "The image's size and its reconstruction filter.",
        params: &[
            Parameter { name: "width", ty: Ty::Whole, default: None, doc: "pixels, 1..65536" },
            Parameter { name: "height", ty: Ty::Whole, default: None, doc: "pixels, 1..65536" },
            Parameter { name: "filter", ty: Ty::Filter, default: Some("box()"), doc: "reconstruction filter" },
        ],
        positional: 2,
        example: "film = image(512, 512)",
        build: |args, _| {
            let side = |name: &'static str| match args.whole(name).unwrap_or(0) {
                size @ 1..=LARGEST_SIDE => Ok(size),
                size => Err(Problem::new(name, format!("`{name}` is {size} pixels, it must be 1 to {LARGEST_SIDE}"))),
            };
            let filter = match args.get("filter") {
                Some(Value::Filter(filter)) => (**filter).clone(),
                _ => Filter::Box { radius: 0.5 },
            };
            Ok(Value::Film(Rc::new(Film { width: side("width")?, height: side("height")?, filter })))
        },
    },
    Constructor {
        family: Family::Filter,
        name: "box",
        summary: "Equal weight within a square round the pixel's center.",
        params: &[Parameter {
            name: "radius",
            ty: Ty::Number,
            default: Some("0.5"),
            doc: "half the side in pixels, > 0",
        }],
        positional: 0,
        example: "film = image(512, 512, filter: box())",
        build: |args, _| Ok(Value::Filter(Rc::new(Filter::Box { radius: above_zero(args, "radius", 0.5)? }))),
    },
    Constructor {
        family: Family::Filter,
        name: "gaussian",
        summary: "A Gaussian that is cut at `radius`, its value there subtracted.",
        params: &[
            Parameter {
                name: "stddev",
                ty: Ty::Number,
                default: Some("0.5"),
                doc: "standard deviation in pixels, > 0",
            },
            Parameter {
                name: "radius",
                ty: Ty::Number,
                default: Some("4 stddev"),
                doc: "half the side in pixels, > 0; four standard deviations if left out",
            },
        ],
        positional: 0,
        example: "film = image(512, 512, filter: gaussian(stddev: 0.5))",
        build: |args, _| {
            let stddev = above_zero(args, "stddev", 0.5)?;
            let radius = above_zero(args, "radius", 4.0 * stddev)?;
            Ok(Value::Filter(Rc::new(Filter::Gaussian { stddev, radius })))
        },
    },
    Constructor {
        family: Family::Integrator,
        name: "path",
        summary: "Unidirectional path tracing with next event estimation. Unbiased.",
        params: MAX_DEPTH,
        positional: 0,
        example: "integrator = path(max_depth: 10)",
        build: |args, _| integrator(args, |max_depth| Integrator::Path { max_depth }),
    },
    Constructor {
        family: Family::Integrator,
        name: "bidirectional",
        summary: "Bidirectional path tracing: paths from the camera and from the lights, connected. Unbiased.",
        params: MAX_DEPTH,
        positional: 0,
        example: "integrator = bidirectional(max_depth: 10)",
        build: |args, _| integrator(args, |max_depth| Integrator::Bidirectional { max_depth }),
    },
    Constructor {
        family: Family::Integrator,
        name: "light_tracing",
        summary: "Paths from the lights, each vertex connected to the camera. Unbiased, but what a mirror or glass shows stays black.",
        params: MAX_DEPTH,
        positional: 0,
        example: "integrator = light_tracing(max_depth: 10)",
        build: |args, _| integrator(args, |max_depth| Integrator::LightTracing { max_depth }),
    },
    Constructor {
        family: Family::Integrator,
        name: "metropolis",
        summary: "Metropolis light transport in primary sample space; samples are mutations per pixel. Unbiased.",
        params: MAX_DEPTH,
        positional: 0,
        example: "integrator = metropolis(max_depth: 10)",
        build: |args, _| integrator(args, |max_depth| Integrator::Metropolis { max_depth }),
    },
    Constructor {
        family: Family::Integrator,
        name: "photon_map",
        summary: "Stochastic progressive photon mapping; samples are passes. Consistent: the blur goes with more passes.",
        params: MAX_DEPTH,
        positional: 0,
        example: "integrator = photon_map(max_depth: 10)",
        build: |args, _| integrator(args, |max_depth| Integrator::PhotonMap { max_depth }),
    },
    Constructor {
        family: Family::Sampler,
        name: "independent",
        summary: "Independent random numbers.",
        params: &[
            Parameter { name: "samples", ty: Ty::Whole, default: None, doc: "samples per pixel, at least 1" },
            Parameter { name: "seed", ty: Ty::Whole, default: Some("0"), doc: "start of the random numbers" },
        ],
        positional: 0,
        example: "sampler = independent(samples: 32)",
        build: |args, _| sampler(args, |samples, seed| Sampler::Independent { samples, seed }),
    },
    Constructor {
        family: Family::Sampler,
        name: "sobol",
        summary: "Points of a Sobol sequence, which lie more evenly than random ones.",
        params: &[
            Parameter {
                name: "samples",
                ty: Ty::Whole,
                default: None,
                doc: "samples per pixel, at least 1; powers of 2 are the best",
            },
            Parameter { name: "seed", ty: Ty::Whole, default: Some("0"), doc: "what the points are scrambled with" },
        ],
        positional: 0,
        example: "sampler = sobol(samples: 64)",
        build: |args, _| sampler(args, |samples, seed| Sampler::Sobol { samples, seed }),
    },
];

fn integrator(args: &Args, make: fn(u32) -> Integrator) -> Result<Value, Problem> {
    match args.whole("max_depth").unwrap_or(0) {
        0 => Err(Problem::new("max_depth", "`max_depth` must be at least 1")
            .note("it counts the segments of a path, the camera's and the light's included")),
        max_depth => Ok(Value::Integrator(Rc::new(make(max_depth)))),
    }
}

fn sampler(args: &Args, make: fn(u32, u32) -> Sampler) -> Result<Value, Problem> {
    match args.whole("samples").unwrap_or(0) {
        0 => Err(Problem::new("samples", "`samples` must be at least 1")),
        samples => Ok(Value::Sampler(Rc::new(make(samples, args.whole("seed").unwrap_or(0))))),
    }
}

fn above_zero(args: &Args, name: &'static str, default: f64) -> Result<f64, Problem> {
    let value = args.number(name).unwrap_or(default);
    if value > 0.0 { Ok(value) } else { Err(Problem::new(name, format!("`{name}` must be greater than 0"))) }
}

fn camera(args: &Args) -> Result<Value, Problem> {
    let (fov, vertical, name) = match (args.number("fov_x"), args.number("fov_y")) {
        (Some(fov), None) => (fov, false, "fov_x"),
        (None, Some(fov)) => (fov, true, "fov_y"),
        (Some(_), Some(_)) => {
            return Err(Problem::new("fov_y", "`fov_x` and `fov_y` are both given")
                .help("remove one: the other follows from the film"));
        }
        (None, None) => {
            return Err(Problem::new(None, "`perspective` needs `fov_x` or `fov_y`")
                .note("renderers disagree on the axis that a bare angle of view belongs to")
                .help("write for example `fov_x: 45deg`"));
        }
    };
    if !(fov > 0.0 && fov < 180.0) {
        return Err(Problem::new(name, format!("`{name}` must lie between 0 and 180 degrees")));
    }
    let near = args.number("near");
    let far = args.number("far");
    if near.is_some_and(|near| near <= 0.0) {
        return Err(Problem::new("near", "`near` must be greater than 0"));
    }
    if let (Some(near), Some(far)) = (near, far)
        && far <= near
    {
        return Err(Problem::new("far", "`far` must be greater than `near`"));
    }
    let eye = args.vec3("eye").unwrap_or_default();
    let target = args.vec3("target").unwrap_or_default();
    let up = args.vec3("up").unwrap_or([0.0, 0.0, 1.0]);
    if eye == target {
        return Err(Problem::new("target", "`target` equals `eye`: the camera looks nowhere"));
    }
    let parallel = {
        let view = crate::ir::normalized(crate::ir::sub(target, eye));
        let up = crate::ir::normalized(up);
        match (view, up) {
            (Some(view), Some(up)) => crate::ir::length(crate::ir::cross(view, up)) < 1e-9,
            _ => true,
        }
    };
    if parallel {
        return Err(Problem::new("up", "`up` is parallel to the viewing direction")
            .help("a camera that looks along Z needs for example `up: Y`"));
    }
    Ok(Value::Camera(Rc::new(CameraValue { eye, target, up, fov, vertical, near, far })))
}
