//! Proofs of targets' answers that are no convention: sections of docs/conventions.md with the numbers, and tests that measure.

use ltsc_core::capability::Feature;
use ltsc_core::manual::Proof;

/// A proof of some answers of some targets.
pub struct Record {
    /// The targets; all if empty.
    pub targets: &'static [&'static str],
    /// What their answers are to.
    pub features: &'static [Feature],
    /// Where it is.
    pub at: At,
}

/// Where a proof is. A test finds each.
pub enum At {
    /// A section of docs/conventions.md, by its heading.
    Section(&'static str),
    /// A test: its file below the project, and its name.
    Test(&'static str, &'static str),
}

impl At {
    /// As pages show it.
    pub fn proof(&self) -> Proof {
        match self {
            Self::Section(heading) => {
                let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-'));
                let anchor = kept.collect::<String>().to_lowercase().replace(' ', "-");
                Proof { name: (*heading).to_owned(), link: format!("conventions.md#{anchor}"), with: String::new() }
            }
            Self::Test(file, name) => {
                Proof { name: format!("test `{name}`"), link: format!("../{file}"), with: String::new() }
            }
        }
    }
}

/// All of them.
pub const RECORDS: &[Record] = &[
    Record {
        targets: &["mitsuba-3", "luxcore", "cycles", "pbrt-v4", "pbrt-v3"],
        features: &[Feature::Seed],
        at: At::Test("tests/suite/seeds.rs", "seeds_change_the_noise_and_not_the_image"),
    },
    // Lowering writes the normals of faces before any target sees the mesh.
    Record {
        targets: &[],
        features: &[Feature::NoNormals],
        at: At::Test("compiler/core/src/lower/tests.rs", "missing_normals_are_those_of_the_faces"),
    },
    Record {
        targets: &["gltf", "glb"],
        features: &[
            Feature::Camera,
            Feature::VertexNormals,
            Feature::TransformedShape,
            Feature::SharedMesh,
            Feature::Instances,
            Feature::Diffuse,
            Feature::ColoredDiffuse,
        ],
        at: At::Test("tests/suite/blender.rs", "every_scene_is_imported_as_it_is"),
    },
    Record {
        targets: &["mitsuba-0.6", "mitsuba-0.5"],
        features: &[
            Feature::Diffuse,
            Feature::Plastic,
            Feature::Principled,
            Feature::GaussianFilter,
            Feature::PhotonMap,
            Feature::IndirectLight,
        ],
        at: At::Section("Mitsuba 0.6"),
    },
];
