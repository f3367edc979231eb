//! The parts of a glTF document that are written, in the order of their keys.

use serde::Serialize;

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Document {
    pub asset: Asset,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extensions_used: Vec<&'static str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extensions_required: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extensions: Option<DocumentExtensions>,
    pub scene: usize,
    pub scenes: Vec<Scene>,
    pub nodes: Vec<Node>,
    pub cameras: Vec<Camera>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<Mesh>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<Material>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub textures: Vec<Texture>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub images: Vec<Image>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub samplers: Vec<TextureSampler>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub accessors: Vec<Accessor>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub buffer_views: Vec<BufferView>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub buffers: Vec<Buffer>,
}

#[derive(Serialize)]
pub struct DocumentExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub lights_punctual: Lights,
}

#[derive(Serialize)]
pub struct Lights {
    pub lights: Vec<Light>,
}

#[derive(Serialize)]
pub struct Light {
    pub name: String,
    pub r#type: &'static str,
    pub color: [f64; 3],
    pub intensity: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spot: Option<Spot>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Spot {
    pub inner_cone_angle: f64,
    pub outer_cone_angle: f64,
}

#[derive(Default, Serialize)]
pub struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual", skip_serializing_if = "Option::is_none")]
    pub lights_punctual: Option<LightIndex>,
    #[serde(rename = "EXT_mesh_gpu_instancing", skip_serializing_if = "Option::is_none")]
    pub instancing: Option<Instancing>,
}

#[derive(Serialize)]
pub struct Instancing {
    pub attributes: Placement,
}

#[derive(Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub struct Placement {
    pub translation: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale: Option<usize>,
}

#[derive(Serialize)]
pub struct Names {
    pub names: Vec<String>,
}

#[derive(Serialize)]
pub struct LightIndex {
    pub light: usize,
}

#[derive(Serialize)]
pub struct Asset {
    pub version: &'static str,
    pub generator: &'static str,
    #[serde(skip_serializing_if = "String::is_empty")]
    pub copyright: String,
    pub extras: Comment,
}

#[derive(Serialize)]
pub struct Comment {
    pub comment: String,
}

#[derive(Serialize)]
pub struct Scene {
    pub name: String,
    pub nodes: Vec<usize>,
    pub extras: Settings,
}

#[derive(Serialize)]
pub struct Settings {
    pub film: Film,
    pub integrator: Integrator,
    pub sampler: Sampler,
}

#[derive(Serialize)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    pub filter: Filter,
}

#[derive(Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Filter {
    Box { radius: f64 },
    Gaussian { stddev: f64, radius: f64 },
}

#[derive(Serialize)]
pub struct Integrator {
    pub r#type: &'static str,
    pub max_depth: u32,
}

#[derive(Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Sampler {
    Independent { samples: u32, seed: u32 },
    Sobol { samples: u32, seed: u32 },
}

#[derive(Default, Serialize)]
pub struct Node {
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translation: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[f64; 16]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub children: Vec<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extensions: Option<NodeExtensions>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<Names>,
}

#[derive(Serialize)]
pub struct Camera {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    pub r#type: &'static str,
    pub perspective: Perspective,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Perspective {
    pub aspect_ratio: f64,
    pub yfov: f64,
    pub znear: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zfar: Option<f64>,
}

#[derive(Serialize)]
pub struct Mesh {
    pub name: String,
    pub primitives: Vec<Primitive>,
}

#[derive(Serialize)]
pub struct Primitive {
    pub attributes: Attributes,
    pub indices: usize,
    pub material: usize,
}

#[derive(Clone, Copy, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub struct Attributes {
    pub position: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<usize>,
    #[serde(rename = "TEXCOORD_0", skip_serializing_if = "Option::is_none")]
    pub texcoord: Option<usize>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Material {
    pub name: String,
    pub pbr_metallic_roughness: Metallic,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emissive_factor: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "is_false")]
    pub double_sided: bool,
    #[serde(skip_serializing_if = "Extensions::is_empty")]
    pub extensions: Extensions,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Metallic {
    pub base_color_factor: [f64; 4],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_color_texture: Option<TextureIndex>,
    pub metallic_factor: f64,
    pub roughness_factor: f64,
}

#[derive(Serialize)]
pub struct TextureIndex {
    pub index: usize,
}

#[derive(Serialize)]
pub struct Texture {
    pub name: String,
    pub sampler: usize,
    pub source: usize,
}

#[derive(Serialize)]
pub struct Image {
    pub name: String,
    #[serde(flatten)]
    pub place: ImagePlace,
}

#[derive(Serialize)]
#[serde(untagged, rename_all_fields = "camelCase")]
pub enum ImagePlace {
    Uri { uri: String },
    View { buffer_view: usize, mime_type: &'static str },
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureSampler {
    pub mag_filter: u32,
    pub min_filter: u32,
    pub wrap_s: u32,
    pub wrap_t: u32,
}

#[derive(Default, Serialize)]
pub struct Extensions {
    #[serde(rename = "KHR_materials_emissive_strength", skip_serializing_if = "Option::is_none")]
    pub emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior", skip_serializing_if = "Option::is_none")]
    pub ior: Option<Ior>,
    #[serde(rename = "KHR_materials_specular", skip_serializing_if = "Option::is_none")]
    pub specular: Option<Specular>,
    #[serde(rename = "KHR_materials_transmission", skip_serializing_if = "Option::is_none")]
    pub transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_volume", skip_serializing_if = "Option::is_none")]
    pub volume: Option<Volume>,
}

impl Extensions {
    pub fn is_empty(&self) -> bool {
        self.names().is_empty()
    }

    /// The names of those in use, sorted.
    pub fn names(&self) -> Vec<&'static str> {
        let Self { emissive_strength, ior, specular, transmission, volume } = self;
        let used = [
            emissive_strength.as_ref().map(|_| "KHR_materials_emissive_strength"),
            ior.as_ref().map(|_| "KHR_materials_ior"),
            specular.as_ref().map(|_| "KHR_materials_specular"),
            transmission.as_ref().map(|_| "KHR_materials_transmission"),
            volume.as_ref().map(|_| "KHR_materials_volume"),
        ];
        used.into_iter().flatten().collect()
    }
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct EmissiveStrength {
    pub emissive_strength: f64,
}

#[derive(Serialize)]
pub struct Ior {
    pub ior: f64,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Specular {
    pub specular_factor: f64,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Transmission {
    pub transmission_factor: f64,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Volume {
    pub thickness_factor: f64,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: usize,
    pub component_type: u32,
    pub count: usize,
    pub r#type: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<[f64; 3]>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: usize,
    pub byte_offset: u64,
    pub byte_length: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<u32>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
    pub byte_length: u64,
}

fn is_false(value: &bool) -> bool {
    !value
}
