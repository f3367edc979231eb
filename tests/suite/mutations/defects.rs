//! The defects: how each is made, and what must find it.

use std::sync::Arc;

use ltsc_core::ir::{Affine, Bsdf, Color, Mesh, Similar, sub};

use super::mutant::{Found, Mutant, view, words};

/// What an injection came to.
pub enum Broken {
    /// The scene is broken.
    Scene,
    /// What was to be added is refused, or the edited text was checked: these are the findings.
    Refused(Vec<Found>),
    /// The scene lacks what the defect needs.
    Impossible,
}

/// A defect.
pub struct Defect {
    /// What is broken, in words.
    pub what: &'static str,
    /// Any of these findings catches it.
    pub codes: &'static [&'static str],
    /// Findings that are also true of the broken scene.
    pub also: &'static [&'static str],
    /// Breaks a scene.
    pub inject: fn(&mut Mutant) -> Broken,
}

/// A change of the Scene that is always possible.
macro_rules! scene {
    ($what:literal, $codes:expr, $also:expr, $inject:expr) => {
        Defect {
            what: $what,
            codes: &$codes,
            also: &$also,
            inject: |mutant| {
                let inject: fn(&mut Mutant) = $inject;
                inject(mutant);
                Broken::Scene
            },
        }
    };
}

/// Statements that are added beside the scene: `@` is the place, 4 units beside the scene.
macro_rules! beside {
    ($what:literal, $codes:expr, $also:expr, $text:literal) => {
        Defect { what: $what, codes: &$codes, also: &$also, inject: |mutant| graft(mutant, $text) }
    };
}

fn graft(mutant: &mut Mutant, text: &str) -> Broken {
    let text = text.replace('@', &words(mutant.beside()));
    match mutant.graft(&text) {
        Ok(()) => Broken::Scene,
        Err(findings) => Broken::Refused(findings),
    }
}

/// Statements that are added at a flat wall: `@` is the stage that takes a mesh there, `%` the same a little higher.
fn at_wall(mutant: &mut Mutant, text: &str, up: f64) -> Broken {
    let place = mutant.wall();
    graft(mutant, &text.replace('@', &place.frame(0.0)).replace('%', &place.frame(up)))
}

pub const DEFECTS: &[Defect] = &[
    // Meshes.
    scene!("a mesh without normals", ["missing-normals"], [], |mutant| mutant.opaque().normals = None),
    scene!("normals of length 1.1", ["non-unit-normals"], [], |mutant| {
        bend(mutant.opaque(), |_, n| n.map(|x| 1.1 * x));
    }),
    scene!("one normal that looks to the back", ["flipped-normals"], [], |mutant| {
        bend(mutant.opaque(), |at, n| if at == 0 { n.map(|x| -x) } else { n });
    }),
    scene!("all normals of a mesh look to the back", ["flipped-normals"], [], |mutant| {
        bend(mutant.opaque(), |_, n| n.map(|x| -x));
    }),
    // A solid that is broken is closed no more, and its face on the floor is then one sheet upon another.
    scene!("one triangle wound the wrong way", ["flipped-normals"], ["overlapping-faces"], |mutant| {
        Arc::make_mut(&mut mutant.opaque().triangles)[0].swap(0, 1);
    }),
    scene!("a triangle without area", ["degenerate-triangles"], [], |mutant| {
        let triangles = Arc::make_mut(&mut mutant.opaque().triangles);
        let [a, b, _] = triangles[0];
        triangles.push([a, b, b]);
    }),
    scene!("a triangle twice", ["duplicate-triangles"], ["overlapping-faces"], |mutant| {
        let triangles = Arc::make_mut(&mut mutant.opaque().triangles);
        triangles.push(triangles[0]);
    }),
    scene!("a coordinate that is no number", ["invalid-mesh"], ["overlapping-faces"], |mutant| {
        Arc::make_mut(&mut mutant.opaque().positions)[0][1] = f32::NAN;
    }),
    beside!(
        "smooth normals that lean far from the faces",
        ["leaning-normals"],
        [],
        "shape ball = sphere(segments: 12, rings: 6) |> translate@ with diffuse(0.5)"
    ),
    beside!(
        "a solid turned inside out",
        ["inside-out-mesh"],
        [],
        "shape block = box(size: 2) |> flip() |> translate@ with diffuse(0.5)"
    ),
    beside!(
        "a mesh of 150 000 triangles",
        ["large-mesh"],
        [],
        "shape ball = sphere(segments: 400, rings: 190) |> translate@ with diffuse(0.5)"
    ),
    beside!(
        "a flat surface of thousands of triangles",
        ["needless-triangles"],
        [],
        "let flat(x: number, y: number) = 0\n\
         shape sheet = height_field(flat, x: -1..1, y: -1..1, vertices: (41, 41)) |> translate@ with diffuse(0.5)"
    ),
    // Places.
    scene!("a mesh that a transform brings to its place", ["misplaced-mesh"], [], |mutant| {
        let added = mutant.graft("shape block = box(size: 2) with diffuse(0.5)");
        assert!(added.is_ok(), "a good piece");
        let place = mutant.beside();
        if let Some((_, shape)) = mutant.scene.shapes.iter_mut().last() {
            shape.transform = Affine::translation(place);
        }
    }),
    scene!("a mirroring transform", ["mirroring-transform"], ["misplaced-mesh"], |mutant| {
        let added = mutant.graft("shape block = box(size: 2) with diffuse(0.5)");
        assert!(added.is_ok(), "a good piece");
        let place = Affine::scaling([-1.0, 1.0, 1.0]).then(&Affine::translation(mutant.beside()));
        if let Some((_, shape)) = mutant.scene.shapes.iter_mut().last() {
            shape.transform = place;
        }
    }),
    beside!(
        "a scene of more than 500 units",
        ["large-extent"],
        [],
        "shape block = box(size: 2) |> translate@ |> translate(x: 600) with diffuse(0.5)"
    ),
    beside!(
        "a plate thinner than a ten thousandth of its coordinates",
        ["far-from-origin"],
        [],
        "shape plate = box(size: (2, 2, 0.0001)) |> translate@ with diffuse(0.5)"
    ),
    // Contacts.
    Defect {
        what: "two surfaces of different materials in one plane",
        codes: &["overlapping-faces"],
        also: &[],
        inject: |mutant| {
            at_wall(mutant, "shape rug = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) @ with diffuse(0.123)", 0.0)
        },
    },
    Defect {
        what: "a wall that is shifted into the plane of another, back to back",
        codes: &["overlapping-faces"],
        also: &[],
        inject: |mutant| {
            at_wall(mutant, "shape wall = rectangle(x: -1..1, y: -1..1, z: 0, normal: -Z) @ with diffuse(0.123)", 0.0)
        },
    },
    Defect {
        what: "an emitter that lies in a wall",
        codes: &["emitter-in-wall"],
        also: &[],
        inject: |mutant| {
            at_wall(mutant, "emitter tile = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) @ with radiance(1)", 0.0)
        },
    },
    Defect {
        what: "glass that stands on a wall",
        codes: &["dielectric-contact"],
        also: &[],
        inject: |mutant| {
            at_wall(mutant, "shape cube = box(x: -1..1, y: -1..1, z: 0..2) @ with dielectric(ior: 1.5)", 0.0)
        },
    },
    Defect {
        what: "glass closer to a wall than the renderers' offsets",
        codes: &["dielectric-contact"],
        also: &[],
        inject: |mutant| {
            at_wall(mutant, "shape cube = box(x: -1..1, y: -1..1, z: 0..2) % with dielectric(ior: 1.5)", 0.0003)
        },
    },
    // Dielectrics.
    beside!(
        "a glass tube without ends",
        ["open-dielectric"],
        [],
        "shape tube = cylinder(radius: 1, z: -1..1, caps: false) |> translate@ with dielectric(ior: 1.5)"
    ),
    beside!(
        "glass turned inside out",
        ["inside-out-dielectric"],
        [],
        "shape cube = box(size: 2) |> flip() |> translate@ with dielectric(ior: 1.5)"
    ),
    beside!(
        "glass that is not surrounded by air",
        ["outside-not-air"],
        [],
        "shape cube = box(size: 2) |> translate@ with dielectric(ior: 1.5, outside: 1.33)"
    ),
    // Materials.
    Defect {
        what: "alpha 0.005",
        codes: &["rough-too-small"],
        also: &[],
        inject: |mutant| {
            for (_, material) in mutant.scene.materials.iter_mut() {
                if let Bsdf::Conductor { alpha, .. } = &mut material.bsdf {
                    *alpha = 0.005;
                    return Broken::Scene;
                }
            }
            graft(mutant, "shape block = box(size: 2) |> translate@ with conductor(eta: 0.2, k: 3.9, alpha: 0.005)")
        },
    },
    beside!(
        "glass of alpha 0.8",
        ["wide-roughness"],
        [],
        "shape block = box(size: 2) |> translate@ with dielectric(ior: 1.5, alpha: 0.8)"
    ),
    beside!(
        "reflectance 1.2",
        ["reflectance-over-one"],
        [],
        "shape block = box(size: 2) |> translate@ with diffuse(rgb(0.5, 1.2, 0.5))"
    ),
    beside!(
        "a negative color",
        ["invalid-argument"],
        [],
        "shape block = box(size: 2) |> translate@ with diffuse(rgb(0.5, -0.1, 0.5))"
    ),
    beside!("a black surface", ["black-surface"], [], "shape block = box(size: 2) |> translate@ with diffuse(0)"),
    beside!(
        "six kinds of scattering",
        ["many-materials"],
        ["wide-roughness"],
        "mesh cube = box(size: 1) |> translate@\n\
         shape a = cube with diffuse(0.5)\n\
         shape b = cube |> translate(x: 2) with conductor(eta: 0.2, k: 3.9, alpha: 0.1)\n\
         shape c = cube |> translate(x: 4) with conductor(eta: 0.2, k: 3.9, alpha: 0)\n\
         shape d = cube |> translate(x: 6) with mirror(0.9)\n\
         shape e = cube |> translate(x: 8) with dielectric(ior: 1.5)\n\
         shape f = cube |> translate(x: 10) with dielectric(ior: 1.5, alpha: 0.1)"
    ),
    beside!(
        "a material of layers",
        ["non-basic-material"],
        [],
        "shape block = box(size: 2) |> translate@ with plastic(0.5, alpha: 0.1)"
    ),
    beside!(
        "a surface that is black from behind",
        ["one-sided-surface"],
        [],
        "shape screen = rectangle(x: -1..1, z: -1..1, y: 0, normal: -Y) |> translate@ with one_sided(diffuse(0.5))"
    ),
    beside!(
        "a color that screens cannot show",
        ["out-of-gamut"],
        [],
        "shape block = box(size: 2) |> translate@ with diffuse(spectrum([(510, 0), (520, 0.9), (530, 0)]))"
    ),
    Defect {
        what: "a saturated color",
        codes: &["saturated-albedo"],
        also: &[],
        inject: |mutant| {
            // Colors drift from the second bounce on.
            if mutant.scene.integrator.max_depth() < 3 {
                return Broken::Impossible;
            }
            graft(mutant, "shape block = box(size: 2) |> translate@ with diffuse(rgb(0.6, 0.05, 0.06))")
        },
    },
    // Names.
    Defect {
        what: "a material of the text that nothing has",
        codes: &["unused-name"],
        also: &[],
        inject: |mutant| Broken::Refused(mutant.edited(|text| format!("{text}\nmaterial forgotten = diffuse(0.25)\n"))),
    },
    scene!("a material of an imported scene that nothing has", ["unused-name"], [], |mutant| {
        let material = mutant.scene.materials.values().next().expect("a material").clone();
        let _handle = mutant.scene.materials.push(material, ltsc_core::diag::Origin::Made);
    }),
    scene!("a mesh of an imported scene that nothing has", ["unused-name"], [], |mutant| {
        let mesh = mutant.opaque().clone();
        let _handle = mutant.scene.meshes.push(mesh, ltsc_core::diag::Origin::Made);
    }),
    // Light.
    scene!("an emitter with smooth normals", ["smooth-emitter"], [], |mutant| bend(mutant.lamp(), lean)),
    beside!("a point light", ["non-mesh-emitter"], [], "emitter bulb = point(position: @, intensity: 10)"),
    Defect {
        what: "a spot light",
        codes: &["non-mesh-emitter"],
        also: &[],
        inject: |mutant| {
            let target = words(mutant.wall().middle);
            let text = format!("emitter stage = spot(position: @, target: {target}, intensity: 1, angle: 20deg)");
            graft(mutant, &text)
        },
    },
    beside!(
        "light from one direction",
        ["non-mesh-emitter"],
        [],
        "emitter sun = directional(direction: -Z, irradiance: 1)"
    ),
    beside!("an environment", ["non-mesh-emitter"], [], "emitter sky = environment(radiance: 1)"),
    scene!("an emitter of radiance 0", ["dark-emitter"], ["unlit-scene"], |mutant| {
        if let Some(emission) = mutant.scene.surfaces_mut().find_map(|shape| shape.emission.as_mut()) {
            emission.radiance = Color::Grey(0.0);
        }
    }),
    scene!("no emitter", ["unlit-scene"], ["black-surface"], |mutant| {
        for shape in mutant.scene.surfaces_mut() {
            shape.emission = None;
        }
    }),
    beside!(
        "an emitter that faces away from everything",
        ["emitter-facing-away"],
        [],
        "emitter lamp = rectangle(x: 0, y: -1..1, z: -1..1, normal: X) |> translate@ with radiance(1)"
    ),
    beside!(
        "a spot light that meets nothing",
        ["emitter-facing-away"],
        ["non-mesh-emitter"],
        "emitter stage = spot(position: @, target: @ + X, intensity: 1, angle: 20deg)"
    ),
    // Cameras.
    scene!("an angle of view in radians where degrees are due", ["odd-field-of-view"], [], |mutant| {
        mutant.camera().fov_x = mutant.camera().fov_x.to_radians();
    }),
    scene!("an angle of view of 170 degrees", ["odd-field-of-view"], [], |mutant| mutant.camera().fov_x = 170.0),
    scene!("a camera that looks the other way", ["nothing-in-view"], [], |mutant| {
        let camera = mutant.camera();
        camera.target = sub(camera.eye, sub(camera.target, camera.eye));
    }),
    scene!("clipping distances that cut the scene off", ["nothing-in-view"], [], |mutant| {
        mutant.camera().near = Some(1e-3);
        mutant.camera().far = Some(1e-2);
    }),
    Defect {
        what: "a camera inside a solid",
        codes: &["camera-inside-mesh"],
        also: &[],
        inject: |mutant| {
            let eye = words(mutant.camera().eye);
            graft(mutant, &format!("shape block = box(size: 2) |> translate{eye} with diffuse(0.5)"))
        },
    },
    Defect {
        what: "a camera inside glass",
        codes: &["camera-in-dielectric"],
        also: &[],
        inject: |mutant| {
            let eye = words(mutant.camera().eye);
            graft(mutant, &format!("shape cube = box(size: 2) |> translate{eye} with dielectric(ior: 1.5)"))
        },
    },
    Defect {
        what: "a surface 0.005 units in front of the camera",
        codes: &["out-of-range-distance"],
        also: &[],
        inject: |mutant| {
            let camera = mutant.camera().clone();
            let (right, forward) = view(&camera);
            let back = words(forward.map(|x| -x));
            let origin = words([0, 1, 2].map(|axis| camera.eye[axis] + 0.005 * forward[axis]));
            let frame = format!("|> frame(x: {}, z: {back}, origin: {origin})", words(right));
            graft(
                mutant,
                &format!("shape pane = rectangle(x: -1..1, y: -1..1, z: 0, normal: Z) {frame} with diffuse(0.5)"),
            )
        },
    },
    scene!("a camera more than 1000 units away", ["out-of-range-distance"], [], |mutant| {
        let camera = mutant.camera();
        let (_, forward) = view(camera);
        camera.eye = [0, 1, 2].map(|axis| camera.target[axis] - 1300.0 * forward[axis]);
    }),
    // Documentation.
    scene!("no brief description", ["undocumented-scene"], [], |mutant| mutant.document(|doc| doc.brief.clear())),
    scene!("no full description", ["undocumented-scene"], [], |mutant| mutant.document(|doc| doc.full.clear())),
    scene!("no classes of light paths", ["undocumented-scene"], [], |mutant| mutant.document(|doc| doc.paths.clear())),
    scene!("a brief description of two things", ["long-brief"], [], |mutant| {
        mutant.document(|doc| doc.brief.push_str(" And quite another thing besides, which has nothing to do with it."));
    }),
    scene!("a similar scene that does not exist", ["unknown-similar"], [], |mutant| {
        mutant.document(|doc| doc.similar.push(similar("no_such_scene")));
    }),
    Defect {
        what: "a similar scene that does not name this one",
        codes: &["one-sided-similar"],
        also: &[],
        inject: |mutant| {
            let Some(other) = mutant.stranger() else { return Broken::Impossible };
            mutant.document(|doc| doc.similar.push(similar(&other)));
            Broken::Scene
        },
    },
    Defect {
        what: "a scene of the same light paths that is not called similar",
        codes: &["same-paths"],
        also: &[],
        inject: |mutant| {
            let Some(other) = mutant.stranger() else { return Broken::Impossible };
            let own = mutant.scene.documentation.paths.clone();
            if let Some(other) = mutant.scenes.get_mut(&other) {
                other.paths = own;
            }
            Broken::Scene
        },
    },
    scene!("a class of paths that no local sampling finds", ["unreachable-paths"], [], |mutant| {
        mutant.document(|doc| doc.paths.push("LSD S+ D S DSE".to_owned()));
    }),
];

fn similar(name: &str) -> Similar {
    Similar { scene: name.to_owned(), reason: "a reason".to_owned() }
}

/// Changes the normals of a mesh.
fn bend(mesh: &mut Mesh, change: impl Fn(usize, [f32; 3]) -> [f32; 3]) {
    let normals = Arc::make_mut(mesh.normals.as_mut().expect("normals"));
    for (at, normal) in normals.iter_mut().enumerate() {
        *normal = change(at, *normal);
    }
}

/// Leans a normal by some 6 degrees.
fn lean(_at: usize, normal: [f32; 3]) -> [f32; 3] {
    let along = if normal[0].abs() < 0.5 { [0.1, 0.0, 0.0] } else { [0.0, 0.1, 0.0] };
    let leaning = [0, 1, 2].map(|axis| normal[axis] + along[axis]);
    let length = leaning.iter().map(|x| x * x).sum::<f32>().sqrt();
    leaning.map(|x| x / length)
}
