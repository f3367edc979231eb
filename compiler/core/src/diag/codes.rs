//! The codes of findings that are not rules, each with its page. A test holds this list against the code.

/// A code and what `ltsc explain` says of it; the first line is its summary.
pub struct Code {
    /// The stable code.
    pub id: &'static str,
    /// What, why, and what to do.
    pub doc: &'static str,
    /// Whether it is a remark or a warning, whose level can be chosen; what is malformed stays an error.
    pub leveled: bool,
}

/// A row of the table: an error.
const fn code(id: &'static str, doc: &'static str) -> Code {
    Code { id, doc, leveled: false }
}

/// A row of the table: a remark or a warning.
const fn remark(id: &'static str, doc: &'static str) -> Code {
    Code { id, doc, leveled: true }
}

/// All codes that are not rules, by name.
pub const CODES: &[Code] = &[
    code(
        "audit-mismatch",
        "A file that was generated says something else than the scene.\n`build` and `emit` read back what they write: the power, area, facing and place of every emitter, what each material reflects at 0, 30, 60 and 80 degrees and its `alpha`, path depth, camera, size of the image, lights, every surface and its place. A difference is a fault of ltsc itself (exit code 70), and nothing is kept. `ltsc audit` asks the same of files that are there: they may have been edited, or be those of an older scene.",
    ),
    code(
        "bad-path",
        "A path in a scene is absolute, leaves the project, or is not written with `/`.\nA scene must mean the same in every checkout and on every system.",
    ),
    code(
        "duplicate-name",
        "A name is declared twice.\nValues have one space of names, and no name hides another; shapes and emitters have names of their own.",
    ),
    code(
        "duplicate-setting",
        "A setting stands twice in a scene.\nThere is one film, integrator and sampler; several cameras need different names.",
    ),
    remark(
        "evaluation-chunks",
        "A test case has too few chunks for a verdict.\nAn image is rendered as independent chunks, and their differences tell its noise. With fewer than 4 it is not known well enough to say whether images agree; 8 are rendered where nothing is said.",
    ),
    code(
        "evaluation-cycle",
        "Parameter sets of an evaluation are each other's `base`.\nA set inherits what its bases have, so that none may inherit from itself.",
    ),
    code(
        "evaluation-duplicate",
        "Two scenes, cases, renderers or values of an evaluation have the same name.\nResults are kept under these names. A scene that is rendered in several ways gets names of its own: `{ scene = \"ring\", name = \"ring, red\", set = { ... } }`.",
    ),
    code(
        "evaluation-key",
        "An evaluation has a key that is not known in its place, or two that exclude each other.\n`docs/evaluation.md` has all keys. Native statements stand under `parameters`, where any name is passed through.",
    ),
    code("evaluation-missing", "An evaluation lacks something that it needs: scenes, a case, the renderer of a case."),
    code(
        "evaluation-name",
        "An evaluation names a renderer, a case, a scene or a parameter set that is not there.\nA renderer is one of `[renderers]`, or has the name of a renderer or target of ltsc.",
    ),
    code(
        "evaluation-parameter",
        "A native parameter is not written as `[name, type, value]`.\nA statement takes a list of such parameters: `film = [[\"pixelFormat\", \"string\", \"rgb\"]]`. The statement's own type has an empty type: `[\"type\", \"\", \"path\"]`. Several values are a list of their own: `[\"cropwindow\", \"float\", [0, 1, 0, 1]]`. Where the type follows from the value, a table is shorter: `integrator = { type = \"path\", maxDepth = 10 }`.",
    ),
    code(
        "evaluation-render",
        "A case of an evaluation cannot be rendered.\nEach case is written for its renderer, read back, and held against what the renderer can do before anything is rendered: algorithms, parameters, seeds, options.",
    ),
    code(
        "evaluation-renderer",
        "A renderer of an evaluation is not there.\n`ltsc renderers list` says which are, `ltsc renderers install` makes a private copy. The exit code is 4.",
    ),
    code(
        "evaluation-scene",
        "A scene of an evaluation is not there, or cannot be rendered for the target of a renderer.\nA name is that of a scene of the project; a path ends in `.lts` or contains `/`, and starts at the evaluation file.",
    ),
    remark(
        "evaluation-seeds",
        "A renderer has no seeds for a case, so that it renders one image only; or a case takes more seeds than there are.\nThe noise of an image is told by independent images of other seeds; without them there are metrics, and no verdict.",
    ),
    code(
        "evaluation-setting",
        "A neutral setting of an evaluation is not known, or a target has nothing like it.\nNeutral settings are translated for every renderer. What only one renderer has is passed through by `parameters`; what one renderer lacks is said otherwise for it, under `for`.",
    ),
    code(
        "evaluation-syntax",
        "An evaluation file is not written in TOML.\nAll errors are listed, and nothing else is said of the file.",
    ),
    code("evaluation-type", "A value of an evaluation has another type than its key takes."),
    remark(
        "evaluation-unused",
        "A renderer, a parameter set or an exclusion of an evaluation has no effect.\nIt may be misspelt, or a leftover.",
    ),
    code(
        "evaluation-value",
        "A value of an evaluation has the right type and no meaning: an empty list, no samples, fewer samples than chunks.\nSamples are those of a whole image, and each of its chunks takes at least one.",
    ),
    code(
        "foreign-file",
        "A file is a scene or a mesh in another format than ltsc's own.\nScenes are read from `.lts` files; importers for other formats come later, and lint will take their files then.",
    ),
    code(
        "foreign-limit",
        "A file of another program is larger, or nested more deeply, than a reader takes.\nThe limits keep a file from being read without end: includes in includes, mixes of mixes.",
    ),
    code(
        "foreign-reference",
        "A file of another program names something that is not there: a file, a mesh, a material, a texture, a group.\nFiles are looked for below the folder of the scene only.",
    ),
    code(
        "foreign-syntax",
        "A file of another program is not written as its format asks for, or says something that is not read.\nWhat would be read wrongly is refused: a setting with another value than the one that is understood is an error, not passed over.",
    ),
    code(
        "foreign-unknown",
        "A file of another program has a statement or a parameter that is not known.\nNothing is passed over: what is not understood may change the image.",
    ),
    code(
        "image-limit",
        "An image has more than 2^27 pixels, 134 million.\nA header of a few bytes can claim any size; `--limit pixels=N`, or `[limits]` in ltsc.toml, raises the limit.",
    ),
    code(
        "index-out-of-range",
        "A list has no element at this index.\nElements are counted from 0, and a range contains both its ends.",
    ),
    code(
        "instance-limit",
        "A scene has more than 10 million shapes and instances.\nThose in a group count as often as the group is placed; `--limit instances=N`, or `[limits]` in ltsc.toml, raises the limit.",
    ),
    code(
        "internal-fault",
        "ltsc itself failed on a file.\nThe other files of the run are checked all the same. Please report it with the file.",
    ),
    code(
        "invalid-argument",
        "An argument has the right type and no meaning, such as a width of 0.\n`ltsc explain NAME` shows the range of each argument of a constructor.",
    ),
    code(
        "invalid-array",
        "A `.npy` file is malformed, or its numbers cannot be used: NaN, another shape, a matrix without inverse.\n`numpy.save(path, array)` writes what is read here; arrays of objects, strings and records are refused.",
    ),
    code("invalid-camera", "A camera looks nowhere, or its angle of view is not between 0 and 180 degrees."),
    code("invalid-emission", "An emitter's radiance is negative or not finite."),
    code("invalid-film", "A film has no pixels, too many, or a filter without extent."),
    code(
        "invalid-group",
        "The instances of a group cannot be multiplied out, or nothing is left in a group after lowering.\nGroups may lie 128 deep in each other and make 10 million shapes and instances.",
    ),
    code(
        "invalid-image-file",
        "An image file is malformed, cut off, or of a kind that no two renderers read alike.\nPNG, JPEG, OpenEXR, PFM and Radiance HDR are read; the label says where in the file. A number that is not finite is an error too:\nMitsuba spreads it over the image, LuxCore refuses the file, others take 0. What can be made plain (layers and windows of OpenEXR,\nother primaries, alpha, negative numbers) is, and a loss says how.",
    ),
    code("invalid-integrator", "A path has no segments."),
    code(
        "invalid-light",
        "A light's strength is negative or not finite, or it has no direction.\nPoint lights have a radiant intensity, directional ones an irradiance, the environment a radiance.",
    ),
    code("invalid-material", "A material's numbers are not finite or outside their range."),
    code(
        "invalid-mesh",
        "A mesh cannot be made: no triangles, an index out of range, numbers beyond single precision.",
    ),
    code(
        "invalid-mesh-file",
        "A mesh file is malformed: truncated, of another format, or its numbers contradict each other.\nThe label says where in the file.",
    ),
    code("invalid-name", "Something has no name, or two things share one where they must not."),
    code(
        "invalid-operation",
        "An operator does not apply to these values, or gives no finite number.\nAngles have units, lengths and colors have none; division by zero is an error where it stands.",
    ),
    code(
        "invalid-path-class",
        "A class of light paths is not written in Heckbert's notation.\nLetters are L, E, D, G and S, with `( ) | * +`: `LDDE`, `LS+DE`. `L` stands first and `E` last; a part of paths, such as `SDS`, has\nneither. The full form says what light and eye are: `LDD S+ D DSE`.",
    ),
    code("invalid-sampler", "A sampler takes no samples."),
    code("invalid-scene", "A scene has nothing to render: no shape, no camera, or an image without pixels."),
    code("invalid-shape", "A shape names a mesh or a material that the scene does not have."),
    code(
        "invalid-statement",
        "A native statement of a test case cannot be written for its target.\nParameters are `[name, type, value]` in the words of the renderer. In Mitsuba an empty type makes an attribute, `[\"type\", \"\", \"path\"]`; in\nPBRT the one called `type` is the directive's own type, and one without name and type a list of numbers; in LuxCore statement and\nname make a key, in Cycles an attribute of the scene. What files are made of, such as `include`, cannot be given.",
    ),
    code(
        "invalid-texture",
        "A texture is given an encoding that its image cannot have, or stands where its image means nothing.\nPNG and JPEG are `\"srgb\"` or `\"linear\"`; OpenEXR, PFM and Radiance HDR hold floats, which are linear in every renderer. The image of an\nenvironment holds floats: codes of 8 bits end at white.",
    ),
    code("invalid-transform", "A shape's transform flattens, mirrors, or leaves the range of single precision."),
    code(
        "list-limit",
        "A list has more than a million elements.\nThe limit keeps a scene from running without end; `--limit list=N`, or `[limits]` in ltsc.toml, raises it.",
    ),
    remark(
        "loss-approximated",
        "The target has no exact equivalent, and an approximation was written; or something in a mesh file was read as the nearest thing that a scene has.\nThe note gives the bound and how it was found. `ltsc explain --target NAME` shows the whole table.",
    ),
    remark(
        "loss-baked",
        "Something was computed before it was written: a transform into vertices, normals, triangles of polygons.\nThe image stays the same.",
    ),
    remark(
        "loss-dropped",
        "A target does not support something, and it was left out; or a mesh file has something that is not read.\n`ltsc explain --target NAME` shows what a target supports. Of a file there is one finding for each kind of thing, a warning where it\ncould be seen in an image (vertex colors, skins), a remark where it could not (names, edges). `ledger.json` has both.",
    ),
    remark(
        "lteval-paths",
        "A configuration of lteval has relative paths.\nThey were paths below lteval's own folder; an evaluation file sees them from the folder in which it lies.",
    ),
    remark(
        "lteval-unread",
        "A part of a configuration of lteval could not be read.\nA configuration is Python, and nothing of it is run: assignments of literals are read (dictionaries, lists, strings, numbers, names assigned before, lists joined by `+`). Functions, loops and calls are listed, and names that they may change are no longer known.",
    ),
    code(
        "memory-limit",
        "The values of a file take more than two gigabytes: lists, spectra, places of instances, vertices.\nThe limit keeps a scene from using up a machine; `--limit memory=N`, or `[limits]` in ltsc.toml, raises it.",
    ),
    remark(
        "mesh-file",
        "A mesh file was read, and something in it is odd: the file may be damaged, or mean something else.",
    ),
    code("misplaced-name", "A setting that has no name was given one."),
    code("misplaced-parameters", "A declaration that cannot be a function has parameters."),
    code("misplaced-statement", "A statement stands where it means nothing: a second scene, or a shape in a library."),
    code("misplaced-with", "`with` stands behind something that is neither shape nor emitter."),
    code("missing-argument", "A constructor lacks an argument that has no default."),
    code("missing-name", "A declaration has no name."),
    code(
        "missing-reason",
        "A suppression gives no reason.\nWho reads the scene later must know why the finding was wanted.",
    ),
    code(
        "missing-setting",
        "A scene lacks its camera, film, integrator or sampler.\nThey are the defaults that test cases replace.",
    ),
    code("missing-unit", "An angle has no unit.\nWrite `45deg` or `0.5rad`; the unit touches the number."),
    code(
        "missing-uvs",
        "A material with a texture lies on a mesh without texture coordinates.\nAll generators but `triangles` make them; a mesh file has them or has not.",
    ),
    remark(
        "missing-version",
        "A file does not say its version of the language.\nThe newest is assumed; write `lts 1` first so that the file keeps its meaning.",
    ),
    code("missing-with", "A shape has no material, or an emitter no radiance."),
    remark(
        "misspelled-statement",
        "A native statement of a test case differs from one of its target by the case of its letters only.\nIt is written as it is, and does not replace the scene's own: PBRT has an `Integrator`, Mitsuba an `integrator`.",
    ),
    code("name-limit", "A name has more than 256 bytes."),
    code(
        "nesting-limit",
        "Brackets or operators are nested too deeply.\nThe limits are 128 brackets and 256 levels of operators; give inner parts names with `let`.",
    ),
    code(
        "no-statements",
        "A test case gives native statements to a target that has no settings.\nglTF says nothing of integrator, sampler and film: what reads it has settings of its own.",
    ),
    remark(
        "not-comparable",
        "Two cases of an evaluation are compared whose images are not the same, however many samples are taken.\nWhat the files for the renderers mean is read back: depth of paths (`maxdepth` 10 of PBRT is 11 segments, `maxDepth` 10 of Mitsuba is 10), filter, size and part of the image, clamping, and algorithms that are biased. The comparison is made all the same, and the finding stands beside its verdict.",
    ),
    code("not-text", "A scene file is not text in UTF-8."),
    code("number-range", "A number is too large for double precision."),
    code("parameter-range", "The value of a scene's parameter lies outside its range."),
    remark(
        "print-renamed",
        "A name of a scene is another one in the text that ltsc writes of it.\nValues of a text (materials, meshes, textures, groups) have one space of names, and other programs have names that the language cannot write: empty ones, and those with control characters, backticks, or more than 256 bytes. A number stands behind a name that is taken; images are the same.",
    ),
    code(
        "reversed-range",
        "A range runs backwards, or an interval is empty.\nRanges contain both ends: `0..8` are nine numbers.",
    ),
    code("scene-name", "A scene is not named as its file."),
    code(
        "second-environment",
        "A scene has two environments.\nMitsuba refuses the second; two constant ones are one with the sum of their radiances.",
    ),
    remark(
        "shadows-builtin",
        "A function has the name of a constructor or function of the language, and takes its place.\nIt is allowed: a version of the language that adds names does not break scenes that have them already.",
    ),
    remark(
        "stale-reference",
        "A reference that ltsc made is of a scene as it was once.\nIt is known by what was written for its renderer: the scene, its settings, or what ltsc writes has changed since.",
    ),
    code(
        "step-limit",
        "A file takes more than ten million steps: calls and iterations, and 32 parts of expressions or elements of lists count as one more.\nThe limit keeps a scene from running without end; `--limit steps=N`, or `[limits]` in ltsc.toml, raises it.",
    ),
    code(
        "syntax-error",
        "The text does not follow the grammar.\nThe statement is left out, and what stands behind it is still checked.",
    ),
    code(
        "triangle-limit",
        "The generators and stages of a scene make more than fifty million triangles.\nThe limit keeps a slip of the pen from using up the memory; `--limit triangles=N`, or `[limits]` in ltsc.toml, raises it.",
    ),
    code("type-mismatch", "A value has another type than its place asks for."),
    code(
        "unformatted",
        "A file is not formatted.\n`ltsc fmt` formats it: the layout changes; comments, numbers and meaning stay.",
    ),
    code(
        "unknown-argument",
        "A constructor has no such argument, or it is given without its label.\n`ltsc explain NAME` shows the arguments of a constructor.",
    ),
    code(
        "unknown-constructor",
        "There is no constructor or function of this name in this place.\n`ltsc explain` lists them all.",
    ),
    code("unknown-field", "A scene's header has no such field."),
    code("unknown-member", "A value has no such member; vectors have `.x`, `.y` and `.z`."),
    code(
        "unknown-name",
        "There is no value of this name.\nNames are declared before they are used; names of other files come by `use`.",
    ),
    code("unknown-parameter", "A parameter was set that the scene does not declare."),
    remark("unknown-rule", "A suppression names no rule."),
    code("unknown-type", "A parameter has an unknown type."),
    code(
        "unknown-unit",
        "A number has an unknown unit.\nAngles have `deg` and `rad`; lengths are scene units, radiance is W/(m2 sr), and both are written without unit.",
    ),
    code("unknown-version", "The file is written in a version of the language that this compiler does not know."),
    code("unreadable-file", "A file is missing, too large, or cannot be read."),
    remark(
        "unused-allow",
        "A suppression suppresses nothing.\nRemove it, so that the finding is shown if it comes back.",
    ),
    code("use-cycle", "Files use each other in a circle."),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_sorted_and_complete_sentences() {
        assert!(CODES.is_sorted_by(|a, b| a.id < b.id));
        for code in CODES {
            assert!(code.doc.lines().next().is_some_and(|line| line.ends_with('.')), "{}", code.id);
        }
    }
}
