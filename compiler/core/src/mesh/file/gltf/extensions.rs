//! Extensions of glTF: which are read, and what a file that requires another one is told.

use super::super::{FileError, Note, shown};
use super::document::Document;

/// What is done with an extension.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Handling {
    /// It is read; what of it is not is said where it stands.
    Read,
    /// It is not read, and materials that have it say so.
    OfMaterials,
    /// It is not read where a file only uses it, and nothing is lost: what it holds stands in the file another time, or is never seen.
    Spare,
}

use Handling::{OfMaterials, Read, Spare};

/// The extensions that are known.
const KNOWN: &[(&str, Handling)] = &[
    // What an application knows of parts of a mesh; nothing that is seen.
    ("EXT_instance_features", Spare),
    ("EXT_mesh_features", Spare),
    ("EXT_mesh_gpu_instancing", Read),
    ("EXT_meshopt_compression", Spare),
    ("EXT_structural_metadata", Spare),
    ("EXT_texture_webp", OfMaterials),
    ("EXT_texture_avif", OfMaterials),
    // Of animations, which are not read and say so themselves.
    ("KHR_animation_pointer", Spare),
    ("KHR_draco_mesh_compression", Spare),
    ("KHR_lights_punctual", Read),
    ("KHR_materials_anisotropy", OfMaterials),
    ("KHR_materials_clearcoat", OfMaterials),
    ("KHR_materials_diffuse_transmission", OfMaterials),
    ("KHR_materials_dispersion", OfMaterials),
    ("KHR_materials_emissive_strength", Read),
    ("KHR_materials_ior", Read),
    ("KHR_materials_iridescence", OfMaterials),
    ("KHR_materials_pbrSpecularGlossiness", Read),
    ("KHR_materials_sheen", OfMaterials),
    ("KHR_materials_specular", Read),
    ("KHR_materials_transmission", Read),
    ("KHR_materials_unlit", Read),
    ("KHR_materials_variants", Read),
    ("KHR_materials_volume", Read),
    ("KHR_materials_volume_scatter", OfMaterials),
    ("KHR_mesh_quantization", Read),
    ("KHR_meshopt_compression", Spare),
    ("KHR_node_visibility", Read),
    ("KHR_texture_basisu", OfMaterials),
    ("KHR_texture_transform", Read),
    ("KHR_xmp", Read),
    ("KHR_xmp_json_ld", Read),
    ("MSFT_texture_dds", OfMaterials),
];

fn handling(name: &str) -> Option<Handling> {
    KNOWN.iter().find(|(known, _)| *known == name).map(|(_, handling)| *handling)
}

/// Whether anything of an extension is read.
pub fn is_read(name: &str) -> bool {
    handling(name) == Some(Read)
}

/// Refuses a file that requires an extension which is not read.
pub fn required(document: &Document<'_>) -> Result<(), FileError> {
    for (at, name) in document.words("extensionsRequired").enumerate() {
        if handling(name) == Some(Read) {
            continue;
        }
        let help = if name.contains("draco") || name.contains("meshopt") {
            "write it without compression: `gltf-transform copy` undoes Draco and meshopt"
        } else if name.contains("texture") {
            "convert its images to PNG or JPEG, and write the file without the extension"
        } else {
            "write the file without it in the program that made it"
        };
        let message = format!("the file requires the extension `{}` of glTF, which is not read", shown(name));
        return Err(FileError::new(format!("/extensionsRequired/{at}"), message).help(help));
    }
    Ok(())
}

/// What a file loses that only uses extensions which are not known.
pub fn used(document: &Document<'_>, notes: &mut Vec<Note>) {
    for (at, name) in document.words("extensionsUsed").enumerate() {
        if handling(name).is_none() {
            let message = format!("the extension `{}` of glTF is not read", shown(name));
            notes.push(Note::dropped(format!("/extensionsUsed/{at}"), message));
        }
    }
}

/// Extensions of materials that are not read: their name, the factor without which they do nothing and whether that is 0 where it
/// is not given, and what is lost.
pub const UNREAD_OF_MATERIALS: &[(&str, &str, bool, &str)] = &[
    ("KHR_materials_anisotropy", "anisotropyStrength", true, "anisotropy (`KHR_materials_anisotropy`)"),
    ("KHR_materials_clearcoat", "clearcoatFactor", true, "a clear coat (`KHR_materials_clearcoat`)"),
    (
        "KHR_materials_diffuse_transmission",
        "diffuseTransmissionFactor",
        true,
        "diffuse transmission (`KHR_materials_diffuse_transmission`)",
    ),
    ("KHR_materials_dispersion", "dispersion", true, "dispersion (`KHR_materials_dispersion`)"),
    ("KHR_materials_iridescence", "iridescenceFactor", true, "iridescence (`KHR_materials_iridescence`)"),
    ("KHR_materials_sheen", "sheenColorFactor", true, "sheen (`KHR_materials_sheen`)"),
    ("KHR_materials_volume_scatter", "", false, "scattering within (`KHR_materials_volume_scatter`)"),
];
