//! What a page shows, as its scripts read it: names, numbers and facts, and which files hold the pixels.

use serde::Serialize;

/// Everything but the pixels.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Model {
    /// The number of this form; it grows where a field goes or means something else.
    pub form: u32,
    /// `ltsc` and its version.
    pub generator: String,
    /// The name of the evaluation or folder.
    pub title: String,
    /// What it is about.
    pub description: String,
    /// When the images were made, where that is known.
    pub date: Option<String>,
    /// Other facts of the whole: the machine, files.
    pub facts: Vec<Fact>,
    /// Test cases as the evaluation file describes them.
    pub cases: Vec<Case>,
    /// Scenes with their images.
    pub scenes: Vec<Scene>,
    /// Images and references, those that are missing too; scenes and pairs name them by their number.
    pub images: Vec<Picture>,
    /// The table of maps.
    pub maps: Vec<Row>,
    /// The table of metrics.
    pub metrics: Vec<Row>,
    /// Plots over all scenes.
    pub plots: Vec<Plot>,
    /// What could not be read, for people.
    pub remarks: Vec<String>,
}

/// A row of a table of formulas.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// What it says.
    pub summary: String,
    /// Its definition.
    pub formula: String,
    /// The least and the largest value; none where there is no bound.
    pub range: (Option<f32>, Option<f32>),
}

/// Something that is known, with its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fact(pub String, pub String);

/// A test case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// Its name.
    pub name: String,
    /// What it is about.
    pub description: String,
    /// The rest of what the file says of it, as text.
    pub settings: String,
}

/// A scene with values of its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Scene {
    /// Its name, with the values.
    pub name: String,
    /// The scene alone.
    pub scene: String,
    /// Its documentation.
    pub documentation: String,
    /// Values of parameters.
    pub parameters: Vec<Fact>,
    /// Numbers of its images, references last.
    pub images: Vec<usize>,
    /// Its comparisons.
    pub pairs: Vec<Pair>,
    /// Its plots.
    pub plots: Vec<Plot>,
    /// Which pixels see what, by the size of images.
    pub groups: Vec<Groups>,
}

/// Which pixels of images of a size see what.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Groups {
    /// Width of the images.
    pub width: usize,
    /// Their height.
    pub height: usize,
    /// The script that brings a number for each pixel.
    pub data: String,
    /// What groups are called, as [`Blamed::group`] names them.
    pub names: Vec<String>,
}

/// A part of a difference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Blamed {
    /// In words.
    pub words: String,
    /// The group of pixels on which it lies.
    pub group: String,
}

/// An image.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Picture {
    /// What people read, and what links name within a scene.
    pub label: String,
    /// `image`, or `reference`.
    pub kind: &'static str,
    /// The case; empty for one that no evaluation knows.
    pub case: String,
    /// The renderer.
    pub renderer: String,
    /// `done`, `failed`, `skipped`, `missing` or `unreadable`.
    pub status: &'static str,
    /// Why there is no image.
    pub why: Option<String>,
    /// Where its file lies, seen from the page; none where the page has no such neighbor.
    pub file: Option<String>,
    /// Where the renderer's log lies.
    pub log: Option<String>,
    /// Where its small picture lies.
    pub thumb: Option<String>,
    /// Where the pixels lie; none without an image.
    pub data: Option<Data>,
    /// How it came to be.
    pub facts: Vec<Fact>,
    /// What the target states of the scene.
    pub stated: Vec<String>,
    /// Samples per pixel.
    pub samples: Option<u64>,
    /// Seconds of rendering.
    pub seconds: Option<f64>,
    /// The standard error of a pixel over the mean.
    pub noise: Option<f64>,
}

/// The pixels of an image.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Data {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Whether all channels are the same, so that one is stored.
    pub grey: bool,
    /// Bytes of a number: 4, or 3 where the page would be large.
    pub bytes: usize,
    /// The smaller image that is shown first; none where the image is small itself.
    pub preview: Option<Preview>,
    /// Parts of the image: left, top, width, height.
    pub tiles: Vec<[usize; 4]>,
    /// Stops that bring the 95th percentile to 0.8.
    pub exposure: f64,
    /// The means of the channels over pixels that are finite.
    pub mean: [Option<f64>; 3],
    /// Pixels that are infinite or not a number.
    pub non_finite: usize,
}

/// A smaller image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Preview {
    /// Pixels of the image along each side of one of it.
    pub factor: usize,
    /// Its width.
    pub width: usize,
    /// Its height.
    pub height: usize,
}

/// A comparison of two images.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Pair {
    /// The number of A, the reference; none where it is not there.
    pub a: Option<usize>,
    /// The number of B.
    pub b: Option<usize>,
    /// A in words.
    pub a_label: String,
    /// B in words.
    pub b_label: String,
    /// `agree`, `differ`, `undecided`, or nothing.
    pub verdict: Option<&'static str>,
    /// What stands behind it.
    pub proof: Option<String>,
    /// B / A in red, green and blue, with its standard error.
    pub channels: Option<[(Option<f64>, f64); 3]>,
    /// What else there is to know: why they are not comparable, what is stated, what was left out.
    pub notes: Vec<String>,
    /// Why there is no verdict.
    pub refused: Option<String>,
    /// Names and values of metrics.
    pub metrics: Vec<(String, Option<f64>)>,
    /// The grid of tiles.
    pub tiles: Option<Tiles>,
    /// On what the difference lies, the largest part first.
    pub blame: Vec<Blamed>,
    /// The cell that differs most for its noise.
    pub worst: Option<Worst>,
}

/// A grid of tiles, row by row.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tiles {
    /// Tiles along each side.
    pub columns: usize,
    /// Rows of tiles.
    pub rows: usize,
    /// B / A over all channels; none where A is black.
    pub ratios: Vec<Option<f64>>,
    /// Half of an interval of 95 % around each ratio; none where the noise is not known.
    pub half: Vec<Option<f64>>,
    /// The verdict on each; empty where there is none.
    pub words: Vec<&'static str>,
    /// The tolerance of a tile, as a share.
    pub tolerance: Option<f64>,
}

/// What is to blame for a verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// Cells along each side of its grid.
    pub grid: usize,
    /// Column and row.
    pub at: (usize, usize),
    /// In words.
    pub words: String,
}

/// A plot that is kept as a file, with its numbers beside it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plot {
    /// What it shows.
    pub title: String,
    /// Its file.
    pub svg: String,
    /// The numbers.
    pub csv: String,
    /// What is seen, for who does not see it.
    pub text: String,
}
