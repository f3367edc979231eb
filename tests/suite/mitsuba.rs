//! Mitsuba's files against what its plugins ask for: elements, attributes, plugins, parameters and their types.
//!
//! The tables are read from the schema `data/schema/scene.xsd` and the plugins' `props.get...` of Mitsuba 0.6, and from the plugin
//! reference and the source of Mitsuba 3.9. Mitsuba 0.x passes over an unknown parameter with a line in its log, Mitsuba 3 refuses it.

use std::collections::BTreeSet;

use ltsc_core::files::{MemoryFiles, MemorySink};
use ltsc_core::formats::{self, Choices};
use ltsc_core::ledger::Ledger;
use ltsc_core::pipeline;

use super::{prepared, root, scenes};

const TARGETS: [&str; 3] = ["mitsuba-0.5", "mitsuba-0.6", "mitsuba-3"];

/// Elements with their attributes; `?` behind one that may be missing, `x y z` and `value` of a scale checked by hand.
const ELEMENTS: &[(&str, &str)] = &[
    ("scene", "version"),
    ("include", "filename"),
    ("default", "name value"),
    ("integrator", "type id?"),
    ("sensor", "type id?"),
    ("sampler", "type id?"),
    ("film", "type id?"),
    ("rfilter", "type id?"),
    ("shape", "type id?"),
    ("bsdf", "type id? name?"),
    ("texture", "type id? name?"),
    ("emitter", "type id?"),
    ("ref", "id name?"),
    ("integer", "name value"),
    ("float", "name value"),
    ("boolean", "name value"),
    ("string", "name value"),
    ("rgb", "name value"),
    ("point", "name x y z"),
    ("vector", "name x y z"),
    ("transform", "name"),
    ("translate", "x y z?"),
    ("scale", "x y z?"),
    ("matrix", "value"),
    ("lookat", "origin target up"),
];

/// Plugins of 0.5 and 0.6: element, type, parameters as `type name`, objects that may lie in it.
const CAMEL: &[(&str, &str, &str, &str)] = &[
    ("integrator", "path", "integer maxDepth, integer rrDepth, boolean strictNormals, boolean hideEmitters", ""),
    ("integrator", "ptracer", "integer maxDepth, integer rrDepth, integer granularity, boolean bruteForce", ""),
    ("integrator", "bdpt", "integer maxDepth, integer rrDepth, boolean lightImage, boolean sampleDirect", ""),
    (
        "integrator",
        "pssmlt",
        "integer maxDepth, integer rrDepth, boolean bidirectional, integer directSamples, integer luminanceSamples, \
         boolean twoStage, float pLarge",
        "",
    ),
    (
        "integrator",
        "sppm",
        "integer maxDepth, integer rrDepth, integer photonCount, integer maxPasses, float initialRadius, float alpha, \
         integer granularity",
        "",
    ),
    (
        "sensor",
        "perspective",
        "float fov, string fovAxis, string focalLength, float nearClip, float farClip, transform toWorld, float \
         shutterOpen, float shutterClose",
        "sampler film",
    ),
    ("sampler", "independent", "integer sampleCount", ""),
    ("sampler", "sobol", "integer sampleCount, integer scramble", ""),
    (
        "film",
        "hdrfilm",
        "integer width, integer height, string fileFormat, string pixelFormat, string componentFormat, boolean banner, \
         boolean attachLog, boolean highQualityEdges",
        "rfilter",
    ),
    ("rfilter", "box", "float radius", ""),
    ("rfilter", "gaussian", "float stddev", ""),
    (
        "shape",
        "ply",
        "string filename, boolean faceNormals, boolean flipNormals, float maxSmoothAngle, boolean srgb, transform toWorld",
        "ref emitter",
    ),
    ("shape", "shapegroup", "", "shape"),
    ("shape", "instance", "transform toWorld", "ref"),
    ("bsdf", "twosided", "", "bsdf ref"),
    ("bsdf", "diffuse", "color reflectance", ""),
    ("bsdf", "conductor", "string material, rgb eta, rgb k, float extEta, color specularReflectance", ""),
    (
        "bsdf",
        "roughconductor",
        "string material, rgb eta, rgb k, float extEta, color specularReflectance, string distribution, float alpha, float \
         alphaU, float alphaV, boolean sampleVisible",
        "",
    ),
    ("bsdf", "dielectric", "float intIOR, float extIOR, color specularReflectance, color specularTransmittance", ""),
    (
        "bsdf",
        "roughdielectric",
        "float intIOR, float extIOR, color specularReflectance, color specularTransmittance, string distribution, float \
         alpha, boolean sampleVisible",
        "",
    ),
    (
        "bsdf",
        "plastic",
        "float intIOR, float extIOR, color diffuseReflectance, color specularReflectance, boolean nonlinear",
        "",
    ),
    (
        "bsdf",
        "roughplastic",
        "float intIOR, float extIOR, color diffuseReflectance, color specularReflectance, boolean nonlinear, string \
         distribution, float alpha, boolean sampleVisible",
        "",
    ),
    ("bsdf", "blendbsdf", "float weight", "bsdf bsdf"),
    ("emitter", "area", "rgb radiance, float samplingWeight", ""),
    ("emitter", "constant", "rgb radiance, float samplingWeight", ""),
    ("emitter", "envmap", "string filename, float scale, float gamma, transform toWorld, boolean cache", ""),
    ("emitter", "point", "point position, rgb intensity, transform toWorld", ""),
    ("emitter", "spot", "transform toWorld, rgb intensity, float cutoffAngle, float beamWidth", ""),
    ("emitter", "directional", "vector direction, rgb irradiance, transform toWorld", ""),
    (
        "texture",
        "bitmap",
        "string filename, string filterType, string wrapMode, float gamma, float uscale, float vscale, float uoffset, float \
         voffset, float maxAnisotropy, boolean cache, string channel",
        "",
    ),
];

/// Plugins of 3.
const SNAKE: &[(&str, &str, &str, &str)] = &[
    ("integrator", "path", "integer max_depth, integer rr_depth, boolean hide_emitters", ""),
    (
        "integrator",
        "ptracer",
        "integer max_depth, integer rr_depth, boolean hide_emitters, integer samples_per_pass",
        "",
    ),
    (
        "sensor",
        "perspective",
        "float fov, string fov_axis, string focal_length, float near_clip, float far_clip, transform to_world, float \
         principal_point_offset_x, float principal_point_offset_y",
        "sampler film",
    ),
    ("sampler", "independent", "integer sample_count, integer seed", ""),
    (
        "film",
        "hdrfilm",
        "integer width, integer height, string file_format, string pixel_format, string component_format, boolean \
         sample_border, boolean compensate",
        "rfilter",
    ),
    ("rfilter", "box", "", ""),
    ("rfilter", "gaussian", "float stddev", ""),
    (
        "shape",
        "ply",
        "string filename, boolean face_normals, boolean flip_tex_coords, boolean flip_normals, transform to_world",
        "ref emitter",
    ),
    ("shape", "shapegroup", "", "shape"),
    ("shape", "instance", "transform to_world", "ref"),
    ("bsdf", "twosided", "boolean allow_transmission", "bsdf ref"),
    ("bsdf", "diffuse", "color reflectance", ""),
    ("bsdf", "conductor", "string material, color eta, color k, color specular_reflectance", ""),
    (
        "bsdf",
        "roughconductor",
        "string material, color eta, color k, color specular_reflectance, string distribution, float alpha, float alpha_u, \
         float alpha_v, boolean sample_visible",
        "",
    ),
    (
        "bsdf",
        "dielectric",
        "float int_ior, float ext_ior, color specular_reflectance, color specular_transmittance",
        "",
    ),
    (
        "bsdf",
        "roughdielectric",
        "float int_ior, float ext_ior, color specular_reflectance, color specular_transmittance, string distribution, float \
         alpha, boolean sample_visible",
        "",
    ),
    (
        "bsdf",
        "plastic",
        "float int_ior, float ext_ior, color diffuse_reflectance, color specular_reflectance, boolean nonlinear",
        "",
    ),
    (
        "bsdf",
        "roughplastic",
        "float int_ior, float ext_ior, color diffuse_reflectance, color specular_reflectance, boolean nonlinear, string \
         distribution, float alpha, boolean sample_visible",
        "",
    ),
    ("bsdf", "principled", "color base_color, float metallic, float roughness, float eta, float specular", ""),
    ("emitter", "area", "rgb radiance", ""),
    ("emitter", "constant", "rgb radiance", ""),
    ("emitter", "envmap", "string filename, float scale, transform to_world, boolean mis_compensation", ""),
    ("emitter", "point", "point position, rgb intensity, transform to_world", ""),
    ("emitter", "spot", "transform to_world, rgb intensity, float cutoff_angle, float beam_width", ""),
    ("emitter", "directional", "vector direction, rgb irradiance, transform to_world", ""),
    (
        "texture",
        "bitmap",
        "string filename, string filter_type, string wrap_mode, boolean raw, transform to_uv, string format",
        "",
    ),
];

/// An element with what lies in it.
#[derive(Debug)]
pub struct Element {
    pub tag: String,
    attributes: Vec<(String, String)>,
    pub inner: Vec<Element>,
}

impl Element {
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }
}

/// Reads the XML that ltsc writes, which has no text between tags; any other is a panic.
pub fn parse(text: &str) -> Element {
    let mut rest = text.strip_prefix("<?xml version=\"1.0\" encoding=\"utf-8\"?>").expect("a declaration").trim_start();
    let mut open: Vec<Element> = Vec::new();
    let mut root = None;
    while !rest.is_empty() {
        if let Some(comment) = rest.strip_prefix("<!--") {
            let end = comment.find("--").expect("an end of the comment");
            rest = comment[end..].strip_prefix("-->").expect("no -- in a comment").trim_start();
            continue;
        }
        let body = rest.strip_prefix('<').unwrap_or_else(|| panic!("text between tags: {rest:.60}"));
        let (tag, after) = body.split_once('>').expect("an end of the tag");
        rest = after.trim_start();
        let closed = if let Some(name) = tag.strip_prefix('/') {
            let element = open.pop().expect("an open element");
            assert_eq!(element.tag, name);
            Some(element)
        } else {
            let (tag, alone) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
            let (name, mut list) = tag.split_once(' ').unwrap_or((tag, ""));
            let mut element = Element { tag: name.to_owned(), attributes: Vec::new(), inner: Vec::new() };
            while !list.is_empty() {
                let (name, more) = list.split_once("=\"").expect("an attribute");
                let (value, more) = more.split_once('"').expect("an end of the value");
                assert!(element.get(name).is_none(), "{name} twice in {tag}");
                element.attributes.push((name.to_owned(), value.to_owned()));
                list = more.trim_start();
            }
            if alone {
                Some(element)
            } else {
                open.push(element);
                None
            }
        };
        if let Some(element) = closed {
            match open.last_mut() {
                Some(outer) => outer.inner.push(element),
                None => assert!(root.replace(element).is_none(), "two roots"),
            }
        }
    }
    assert!(open.is_empty(), "{open:?}");
    root.expect("a root")
}

const VALUES: [&str; 9] = ["integer", "float", "boolean", "string", "rgb", "point", "vector", "transform", "ref"];

/// Checks an element and what lies in it against the tables.
fn judge(what: &str, plugins: &[(&str, &str, &str, &str)], element: &Element) {
    let tag = element.tag.as_str();
    let (_, known) =
        ELEMENTS.iter().find(|(name, _)| *name == tag).unwrap_or_else(|| panic!("{what}: an element {tag}"));
    let known: Vec<(&str, bool)> =
        known.split(' ').map(|name| (name.trim_end_matches('?'), name.ends_with('?'))).collect();
    for (name, optional) in &known {
        assert!(*optional || element.get(name).is_some(), "{what}: {element:?} lacks {name}");
    }
    for (name, _) in &element.attributes {
        assert!(known.iter().any(|(other, _)| other == name), "{what}: {tag} has no attribute {name}");
    }
    values(what, element);
    let Some(kind) = element.get("type") else {
        for inner in &element.inner {
            judge(what, plugins, inner);
        }
        return;
    };
    let (_, _, parameters, objects) = plugins
        .iter()
        .find(|(of, name, _, _)| *of == tag && *name == kind)
        .unwrap_or_else(|| panic!("{what}: there is no {tag} {kind}"));
    let parameters: Vec<(&str, &str)> =
        parameters.split(", ").filter_map(|parameter| parameter.split_once(' ')).collect();
    let mut seen = BTreeSet::new();
    let mut lying = Vec::new();
    for inner in &element.inner {
        match inner.get("name").filter(|_| VALUES.contains(&inner.tag.as_str())) {
            Some(name) => {
                let asked = parameters.iter().find(|(_, known)| *known == name);
                let (asked, _) = asked.unwrap_or_else(|| panic!("{what}: {tag} {kind} has no parameter {name}"));
                let given = inner.tag.as_str();
                let fits = *asked == given || (*asked == "color" && ["rgb", "ref"].contains(&given));
                assert!(fits, "{what}: {name} of {tag} {kind} is {asked}, not {given}");
                assert!(seen.insert(name), "{what}: {name} of {tag} {kind} twice");
            }
            None => lying.push(inner.tag.as_str()),
        }
        judge(what, plugins, inner);
    }
    let mut allowed: Vec<&str> = objects.split(' ').collect();
    for object in lying {
        let at = allowed.iter().position(|known| *known == object);
        let at = at.unwrap_or_else(|| panic!("{what}: a {object} too many in {tag} {kind}"));
        // A group has any number of shapes.
        if object != "shape" {
            allowed.remove(at);
        }
    }
}

/// What values are written like.
fn values(what: &str, element: &Element) {
    let numbers = |text: &str, separator: &str| -> usize {
        text.split(separator)
            .map(|word| word.parse::<f64>().map(|_| 1).unwrap_or_else(|_| panic!("{what}: {text}")))
            .sum()
    };
    let value = element.get("value").unwrap_or_default();
    match element.tag.as_str() {
        "integer" => {
            assert!(value == "$samples" || value == "$seed" || value.parse::<i32>().is_ok(), "{what}: {element:?}")
        }
        "float" => assert_eq!(numbers(value, ","), 1, "{what}: {element:?}"),
        "boolean" => assert!(["true", "false"].contains(&value), "{what}: {element:?}"),
        "rgb" => assert_eq!(numbers(value, ", "), 3, "{what}: {element:?}"),
        "matrix" => assert_eq!(numbers(value, " "), 16, "{what}: {element:?}"),
        "translate" | "scale" | "point" | "vector" => {
            for (name, value) in &element.attributes {
                assert!(name == "name" || numbers(value, ",") == 1, "{what}: {element:?}");
            }
        }
        "lookat" => {
            for (_, value) in &element.attributes {
                assert_eq!(numbers(value, ", "), 3, "{what}: {element:?}");
            }
        }
        _ => {}
    }
}

/// Ids are unique, what is referred to is there, before its use; gives how many references there are.
fn references(what: &str, roots: &[Element]) -> usize {
    fn walk<'a>(what: &str, element: &'a Element, ids: &mut BTreeSet<&'a str>, count: &mut usize) {
        for inner in &element.inner {
            walk(what, inner, ids, count);
        }
        if let Some(id) = element.get("id") {
            if element.tag == "ref" {
                assert!(ids.contains(id), "{what}: nothing is called {id}");
                *count += 1;
            } else {
                assert!(ids.insert(id), "{what}: two things are called {id}");
            }
        }
    }
    let (mut ids, mut count) = (BTreeSet::new(), 0);
    for root in roots {
        walk(what, root, &mut ids, &mut count);
    }
    count
}

/// Checks the three files of a folder.
fn folder(what: &str, target: &str, read: impl Fn(&str) -> String) {
    let plugins = if target == "mitsuba-3" { SNAKE } else { CAMEL };
    let version = match target {
        "mitsuba-0.5" => "0.5.0",
        "mitsuba-0.6" => "0.6.0",
        _ => "3.0.0",
    };
    let roots = ["scene.xml", "settings.xml", "description.xml"].map(|file| parse(&read(file)));
    for root in &roots {
        assert_eq!((root.tag.as_str(), root.get("version")), ("scene", Some(version)), "{what}");
        judge(what, plugins, root);
    }
    let count = |tag: &str| roots.iter().flat_map(|root| &root.inner).filter(|inner| inner.tag == tag).count();
    assert_eq!((count("integrator"), count("sensor"), count("include")), (1, 1, 2), "{what}");
    assert!(count("shape") > 0 && references(what, &roots) > 0, "{what}");
}

#[test]
fn generated_files_say_only_what_mitsuba_knows() {
    for scene in scenes() {
        for target in TARGETS {
            let path = root().join("generated").join(&scene).join(target);
            folder(&format!("{scene} for {target}"), target, |file| {
                std::fs::read_to_string(path.join(file)).expect("a file")
            });
        }
    }
}

/// Everything that a scene can hold; INTEGRATOR, SAMPLER and FILTER are put in.
const ALL: &str = "lts 1
scene all {}
camera = perspective(eye: (0, -9, 2), target: (0, 0, 1), fov_x: 40deg, near: 0.5, far: 500)
film = image(64, 48, filter: FILTER)
integrator = INTEGRATOR
sampler = SAMPLER
texture tiles = bitmap(\"tiles.png\")
texture raw = bitmap(\"tiles.png\", encoding: \"linear\")
shape a1 = rectangle(x: -4..4, y: -4..4, z: 0, normal: Z) with diffuse(tiles)
shape a2 = sphere() |> translate(-3, 0, 1) with diffuse(raw)
shape a3 = sphere() |> translate(-2, 1, 1) with diffuse(spectrum([(400, 0.1), (700, 0.6)]))
shape a4 = sphere() |> translate(0, 2, 1) with conductor(eta: rgb(0.2, 0.9, 1.1), k: rgb(3.9, 2.4, 2.1), alpha: 0)
shape a5 = sphere() |> translate(1, 3, 1) with conductor(eta: rgb(0.2, 0.9, 1.1), k: rgb(3.9, 2.4, 2.1), alpha: 0.2)
shape a6 = sphere() |> translate(2, 0, 1.5) with dielectric(ior: 1.5)
shape a7 = sphere() |> translate(3, 2, 1.5) with dielectric(ior: 1.5, outside: 1.1, alpha: 0.2)
shape a8 = sphere() |> translate(-3, 3, 1) with mirror(rgb(0.9, 0.8, 0.7))
shape b1 = sphere() |> translate(3, -1, 1) with plastic(0.5)
shape b2 = sphere() |> translate(3, 3.5, 1) with plastic(tiles, alpha: 0.3)
shape b3 = sphere() |> translate(-1, 3.5, 1) with principled(0.5, metallic: 0.3)
shape b4 = sphere() |> translate(-2, 3.5, 1) with principled(tiles, metallic: 1, roughness: 0)
shape b5 = sphere() |> translate(-3.5, 3.5, 1) with principled(0.4)
shape b6 = triangles(positions: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces: [(0, 1, 2)]) |> translate(0, 0, 4) with diffuse(0.5)
group pair {
    shape left = box(size: 1) with diffuse(0.5)
    shape right = box(size: 1) |> translate(2, 0, 0) with mirror()
    emitter lamp = rectangle(x: -1..1, y: -1..1, z: 3, normal: -Z) with radiance(3)
}
instance i1 = pair |> translate(0, 0, 5)
instance i2 = pair |> rotate(z: 30deg) |> translate(0, 0, 9)
emitter lamp = rectangle(x: -1..1, y: -1..1, z: 20, normal: -Z) with radiance(rgb(1, 2, 3), over: diffuse(0.2))
emitter bulb = point(position: (0, 0, 19), intensity: 10)
emitter sun = directional(direction: (1, 2, -4), irradiance: 3)
emitter beam = spot(position: (0, -5, 6), target: (0, 1, 0), intensity: 9, angle: 30deg, inner: 20deg)
emitter sky = environment(radiance: SKY)
";

#[test]
fn everything_that_a_scene_can_hold_is_known_to_mitsuba() {
    let image = std::fs::read(root().join("scenes-src/textures/tiles.png")).expect("an image");
    let integrators = ["path", "bidirectional", "light_tracing", "metropolis", "photon_map"];
    let samplers = ["independent(samples: 4)", "sobol(samples: 4, seed: 3)"];
    let filters = ["box()", "box(radius: 1)", "gaussian(stddev: 0.4)"];
    let skies = ["0.3", "bitmap(\"sky.pfm\")"];
    let sky = [b"PF\n2 1\n-1.0\n".as_slice(), &[0; 24]].concat();
    let mut plugins = BTreeSet::new();
    for (at, integrator) in integrators.iter().enumerate() {
        let mut files = MemoryFiles::default();
        let text = ALL
            .replace("INTEGRATOR", &format!("{integrator}(max_depth: 5)"))
            .replace("SAMPLER", samplers[at % 2])
            .replace("FILTER", filters[at % 3])
            .replace("SKY", skies[at % 2]);
        files.insert("all.lts", text);
        files.insert("tiles.png", image.clone());
        files.insert("sky.pfm", sky.clone());
        let scene = prepared(&files, "all.lts");
        for target in TARGETS {
            let target = formats::find(target).expect("a target");
            let camera = pipeline::camera(&scene, None).expect("a camera");
            let mut sink = MemorySink::default();
            let ledger = Ledger::of(&scene, target, &[]);
            pipeline::emit_shared(&scene, camera, target, &ledger, &Choices::default(), &mut sink)
                .expect("memory takes all");
            let read = |file: &str| String::from_utf8(sink.files[file].clone()).expect("text");
            folder(&format!("{integrator} for {}", target.name), target.name, read);
            for file in ["settings.xml", "description.xml"] {
                let text = read(file);
                let types = text.split("type=\"").skip(1).filter_map(|rest| rest.split('"').next());
                plugins.extend(types.map(|plugin| (target.name == "mitsuba-3", plugin.to_owned())));
            }
        }
    }
    // Nothing stands in the tables that is never written: what is not checked need not be there.
    let unused: Vec<_> = [(false, CAMEL), (true, SNAKE)]
        .into_iter()
        .flat_map(|(new, table)| table.iter().map(move |(_, plugin, _, _)| (new, (*plugin).to_owned())))
        .filter(|plugin| !plugins.contains(plugin))
        .collect();
    assert!(unused.is_empty(), "{unused:?}");
}

#[test]
fn the_tables_find_faults() {
    let good = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<scene version=\"0.6.0\">\n\t<bsdf type=\"conductor\" id=\"a\">\n\
                \t\t<rgb name=\"eta\" value=\"1, 2, 3\"/>\n\t\t<float name=\"extEta\" value=\"1\"/>\n\t</bsdf>\n</scene>\n";
    judge("good", CAMEL, &parse(good));
    let fails = |from: &str, to: &str, plugins: &'static [(&str, &str, &str, &str)]| {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good);
        std::panic::catch_unwind(|| judge("bad", plugins, &parse(&text))).is_err()
    };
    assert!(fails("eta", "Eta", CAMEL));
    assert!(fails("1, 2, 3", "1 2 3", CAMEL));
    assert!(fails("<rgb", "<spectrum", CAMEL));
    assert!(fails("float", "integer", CAMEL));
    assert!(fails("conductor", "metal", CAMEL));
    assert!(fails("id=\"a\"", "ref=\"a\"", CAMEL));
    assert!(fails("1, 2, 3", "4, 5, 6", SNAKE), "extEta is none of Mitsuba 3's");
}
