//! The page in a headless Chromium: opened from the disk, without a complaint or a request; what it shows is what is computed here; keys,
//! pointers, links, files; strange names and numbers; accessibility.

use std::fs;
use std::path::Path;

use ltsc_evaluation::compare::{MAPS, Pair};
use ltsc_render::image::{Image, read};
use serde_json::{Value, json};

use super::browser::Browser;
use super::page::{HOSTILE, Stage, model, ramp, strange};
use super::{root, skip};

/// A small window: drawing without a graphics processor takes its time.
const WINDOW: (u32, u32) = (1100, 620);

/// How far what the page computes may be off, absolutely or as a share of the value.
const CLOSE: f64 = 1e-3;

/// A view of the first scene of the real results.
fn view(more: &str) -> String {
    format!("#view?scene=cbox_classic&a=path%2Fmitsuba-3&b=path%2Fluxcore{more}")
}

fn sides(stage: &Stage) -> (Image, Image) {
    let image = |name: &str| read(&stage.path(&format!("real/scenes/cbox_classic/{name}.exr"))).expect("an image").0;
    (image("path-mitsuba-3"), image("path-luxcore"))
}

/// Values of a map in both forms of the page: by the graphics processor (or a worker), and without it.
fn compare(browser: &mut Browser, name: &str, wanted: &[f32], cpu: bool) {
    browser.eval(&format!("ltsc.state.set({{ show: 'map', map: '{name}', layout: 'single' }})"));
    browser.settle();
    let found = browser.floats(&format!("ltsc.draw.values({cpu}).then((v) => v.numbers)"));
    assert_eq!(found.len(), 4 * wanted.len(), "{name}");
    for (at, wanted) in wanted.iter().enumerate() {
        let (found, known) = (f64::from(found[4 * at]), found[4 * at + 3]);
        assert_eq!(known > 0.5, !wanted.is_nan(), "{name}: pixel {at}");
        let wanted = f64::from(*wanted);
        let off = (found - wanted).abs();
        assert!(
            wanted.is_nan() || off <= CLOSE * wanted.abs().max(1.0),
            "{name}, cpu {cpu}, pixel {at}: {found}, not {wanted}"
        );
    }
}

fn quiet(browser: &mut Browser) {
    assert_eq!(browser.problems(), Vec::<String>::new());
    assert_eq!(browser.requests(), Vec::<String>::new());
    assert_eq!(browser.eval("ltsc.errors"), json!([]));
}

#[test]
fn every_map_has_the_values_that_are_computed_here() {
    let stage = Stage::real();
    let index = stage.report("real");
    if let Some(browser) = Browser::start("every_map_has_the_values_that_are_computed_here", WINDOW) {
        maps(browser, &stage, &index);
    }
}

#[test]
#[ignore = "long: a second browser"]
fn firefox_shows_the_same() {
    let stage = Stage::real();
    let index = stage.report("real");
    for of in [maps, drawn, keys] {
        if let Some(browser) = Browser::firefox("firefox_shows_the_same", WINDOW) {
            of(browser, &stage, &index);
        }
    }
}

fn maps(mut browser: Browser, stage: &Stage, index: &Path) {
    browser.open(index, &view(""));
    let (a, b) = sides(stage);
    let pair = Pair::new(&a, &b).expect("a pair");
    assert_eq!(browser.eval("ltsc.gpu.start()"), true, "WebGL is there");
    for map in MAPS {
        let wanted = (map.measure)(&pair).expect("values");
        compare(&mut browser, map.name, &wanted, false);
        compare(&mut browser, map.name, &wanted, true);
    }
    // Images themselves are exact.
    browser.eval("ltsc.state.set({ show: 'b' })");
    browser.settle();
    let found = browser.floats("ltsc.draw.values(false).then((v) => v.numbers)");
    let found: Vec<[f32; 3]> = found.chunks_exact(4).map(|four| [four[0], four[1], four[2]]).collect();
    assert_eq!(found, b.pixels);
    // A program that is not taken, as old drivers do: the processor draws and reads from then on.
    let works =
        browser.text("(ltsc.kept = ltsc.fragment, ltsc.fragment = () => 'no program', ltsc.errors.length.toString())");
    assert_eq!(works, "0");
    let wanted = (MAPS[1].measure)(&pair).expect("values");
    // No other drawing has had so many samples of a pixel of the screen.
    browser.eval("ltsc.state.set({ zoom: 0.15 })");
    compare(&mut browser, MAPS[1].name, &wanted, false);
    assert_eq!(browser.eval("ltsc.gpu.start()"), false);
    assert!(browser.text("ltsc.errors[0]").starts_with("WebGL: "));
    browser.eval("ltsc.fragment = ltsc.kept; ltsc.errors.length = 0");
    quiet(&mut browser);
}

/// The first pane's canvas: width, height, and its bytes.
fn canvas(browser: &mut Browser) -> (usize, usize, Vec<[u8; 4]>) {
    let size = browser.eval("[ltsc.draw.panes()[0].canvas.width, ltsc.draw.panes()[0].canvas.height]");
    let side = |at: usize| size[at].as_u64().expect("a number") as usize;
    let read = "(() => { const c = ltsc.draw.panes()[0].canvas; const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
                return d; })()";
    let bytes = browser.bytes(read);
    (side(0), side(1), bytes.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]).collect())
}

fn srgb(linear: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Asserts that the canvas shows `wanted` of each pixel of the image, at whole zoom.
fn shows(browser: &mut Browser, image: (usize, usize), wanted: impl Fn(usize, usize) -> [f64; 3], what: &str) {
    let at = browser.eval(
        "(() => { const p = ltsc.draw.place(ltsc.draw.panes()[0]); return [p.zoom, p.origin[0], p.origin[1]]; })()",
    );
    let number = |index: usize| at[index].as_f64().expect("a number");
    let (zoom, left, top) = (number(0), number(1), number(2));
    let (width, height, found) = canvas(browser);
    let mut seen = 0;
    for y in 0..image.1 {
        for x in 0..image.0 {
            // The middle of the pixel, where no line of the grid lies.
            let (u, v) = ((x as f64 + 0.5 - left) * zoom, (y as f64 + 0.5 - top) * zoom);
            if u < 0.0 || v < 0.0 || u as usize >= width || v as usize >= height {
                continue;
            }
            let found = found[v as usize * width + u as usize];
            let wanted = wanted(x, y);
            for channel in 0..3 {
                let off = (f64::from(found[channel]) - 255.0 * wanted[channel]).abs();
                assert!(off <= 1.01, "{what}: pixel {x}, {y} is {found:?}, not {:?}", wanted.map(|v| 255.0 * v));
            }
            seen += 1;
        }
    }
    assert!(seen > 100, "{what}: {seen} pixels were seen");
}

#[test]
fn what_is_drawn_is_what_is_said() {
    let stage = Stage::real();
    let index = stage.report("real");
    if let Some(browser) = Browser::start("what_is_drawn_is_what_is_said", WINDOW) {
        drawn(browser, &stage, &index);
    }
}

fn drawn(mut browser: Browser, stage: &Stage, index: &Path) {
    let (a, b) = sides(stage);
    let size = (a.width, a.height);
    let luminance = |[r, g, b]: [f32; 3]| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
    for cpu in [0, 1] {
        browser.open(index, &view(&format!("&cpu={cpu}&ev=1&zoom=8&mev=2")));
        let color = |image: &Image, x, y, gain: f64| image.at(x, y).map(|value| srgb(f64::from(value) * gain));
        shows(&mut browser, size, |x, y| color(&b, x, y, 2.0), "B, a stop brighter");
        browser.key(" ");
        shows(&mut browser, size, |x, y| color(&a, x, y, 2.0), "A");
        browser.key("e");
        assert_eq!(browser.eval("ltsc.state.now.ev"), 1.5);
        shows(&mut browser, size, |x, y| color(&a, x, y, 2_f64.powf(1.5)), "A, half a stop brighter");
        browser.key("E");
        browser.key("t");
        browser.eval("ltsc.state.set({ gamma: 2 })");
        browser.settle();
        shows(&mut browser, size, |x, y| a.at(x, y).map(|v| (2.0 * f64::from(v)).clamp(0.0, 1.0).sqrt()), "gamma 2");
        browser.eval("ltsc.state.set({ tone: 'srgb', channel: 'g' })");
        browser.settle();
        shows(&mut browser, size, |x, y| [srgb(2.0 * f64::from(a.at(x, y)[1])); 3], "the green channel");
        browser.eval("ltsc.state.set({ channel: 'lum' })");
        browser.settle();
        shows(&mut browser, size, |x, y| [srgb(2.0 * luminance(a.at(x, y))); 3], "luminance");
        browser.eval("ltsc.state.set({ channel: 'rgb', show: 'map', map: 'signed' })");
        browser.settle();
        let map = MAPS.iter().find(|map| map.name == "signed").expect("the map");
        let values = (map.measure)(&Pair::new(&a, &b).expect("a pair")).expect("values");
        let signed = |x: usize, y: usize| {
            let value = f64::from(values[y * size.0 + x]);
            let shown = srgb(value.abs() * 4.0);
            if value > 0.0 { [0.0, shown, 0.0] } else { [shown, 0.0, 0.0] }
        };
        shows(&mut browser, size, signed, "the signed difference, two stops brighter");
        browser.eval("ltsc.state.set({ layout: 'split', split: 0.5, zoom: 8, cx: 0.5, cy: 0.5 })");
        browser.settle();
        let half = |x: usize, y: usize| color(if x < size.0 / 2 { &a } else { &b }, x, y, 2.0);
        // The pixels beside the line have it drawn over them, as has the handle.
        let apart = |x: usize, y: usize| x.abs_diff(size.0 / 2) > 1 || y.abs_diff(size.1 / 2) > 3;
        let (width, _, found) = canvas(&mut browser);
        let place = browser.eval("ltsc.draw.place(ltsc.draw.panes()[0]).origin");
        for y in 4..size.1 - 4 {
            for x in (4..size.0 - 4).filter(|x| apart(*x, y)) {
                let at = |pixel: usize, axis: usize| {
                    ((pixel as f64 + 0.5 - place[axis].as_f64().expect("a number")) * 8.0) as usize
                };
                if x.abs_diff(size.0 / 2) > 1 {
                    let (found, wanted) = (found[at(y, 1) * width + at(x, 0)], half(x, y));
                    let off = |channel: usize| (f64::from(found[channel]) - 255.0 * wanted[channel]).abs();
                    assert!((0..3).all(|channel| off(channel) <= 1.01), "split: {x}, {y}: {found:?}");
                }
            }
        }
    }
    quiet(&mut browser);
}

#[test]
fn keys_pointers_and_links_do_what_the_sheet_says() {
    let stage = Stage::real();
    let index = stage.report("real");
    if let Some(browser) = Browser::start("keys_pointers_and_links_do_what_the_sheet_says", WINDOW) {
        keys(browser, &stage, &index);
    }
}

fn keys(mut browser: Browser, stage: &Stage, index: &Path) {
    browser.open(index, &view(""));
    let state = |browser: &mut Browser, name: &str| browser.eval(&format!("ltsc.state.now.{name}"));
    // Images by digits and arrows, of A with Shift.
    browser.key("Digit3");
    assert_eq!(browser.text("ltsc.book.images[ltsc.state.now.b].label"), "shallow");
    browser.key("Shift+Digit2");
    assert_eq!(browser.text("ltsc.book.images[ltsc.state.now.a].label"), "path/luxcore");
    browser.key("Shift+ArrowRight");
    assert_eq!(browser.text("ltsc.book.images[ltsc.state.now.b].label"), "path/mitsuba-3");
    browser.key("w");
    assert_eq!(browser.text("ltsc.book.images[ltsc.state.now.a].label"), "path/mitsuba-3");
    browser.key("Shift+ArrowDown");
    assert_eq!(browser.text("ltsc.book.scenes[ltsc.state.now.scene].name"), "pool_simple, lamp_side=20");
    assert_eq!(browser.text("ltsc.book.images[ltsc.state.now.a].label"), "path/mitsuba-3");
    browser.key("Shift+ArrowUp");
    // Maps, zoom, pan, reset.
    browser.key("]");
    assert_eq!((state(&mut browser, "map"), state(&mut browser, "show")), (json!("absolute"), json!("map")));
    browser.key("[");
    let fit = browser.eval("ltsc.draw.place(ltsc.draw.panes()[0]).zoom").as_f64().expect("a zoom");
    browser.key("=");
    assert_eq!(state(&mut browser, "zoom"), 2.0 * fit);
    browser.key("ArrowRight");
    assert!(state(&mut browser, "cx").as_f64().is_some_and(|x| x > 0.5));
    browser.key("f");
    assert_eq!((state(&mut browser, "zoom"), state(&mut browser, "cx")), (Value::Null, json!(0.5)));
    browser.key("t");
    browser.key("E");
    browser.key("r");
    assert_eq!([state(&mut browser, "tone"), state(&mut browser, "mev")], [json!("srgb"), Value::Null]);
    // The wheel keeps the pixel under the pointer, and a drag moves with it.
    let pixel = "(() => { const p = ltsc.draw.place(ltsc.draw.panes()[0]); const b = ltsc.draw.panes()[0].canvas.getBoundingClientRect(); \
                 return [p.origin[0] + (400 - b.left) / p.zoom, p.origin[1] + (300 - b.top) / p.zoom]; })()";
    let place = |browser: &mut Browser| {
        let found = browser.eval(pixel);
        (found[0].as_f64().expect("a number"), found[1].as_f64().expect("a number"))
    };
    let before = place(&mut browser);
    browser.pointer(&[(400.0, 300.0)], 0, -300.0);
    let after = place(&mut browser);
    assert!((before.0 - after.0).abs() < 0.1 && (before.1 - after.1).abs() < 0.1, "{before:?} {after:?}");
    assert_eq!(state(&mut browser, "zoom"), 2.0 * fit);
    browser.pointer(&[(400.0, 300.0), (430.0, 320.0), (460.0, 340.0)], 0, 0.0);
    let moved = place(&mut browser);
    assert!((after.0 - moved.0 - 60.0 / (2.0 * fit)).abs() < 0.1, "{after:?} {moved:?}");
    // A click pins a pixel, Shift and a drag draws a line.
    browser.pointer(&[(400.0, 300.0), (400.0, 300.0)], 0, 0.0);
    let pin = state(&mut browser, "pin");
    assert_eq!(pin, json!([moved.0.floor() as i64, moved.1.floor() as i64]));
    let (a, b) = sides(stage);
    let (x, y) = (moved.0 as usize, moved.1 as usize);
    let table = browser.text("document.querySelector('table.values').textContent");
    let shown = browser.text(&format!("ltsc.number({}, 4)", b.at(x, y)[1]));
    assert!(table.contains(&shown), "{shown} in {table}");
    let value = (MAPS[0].measure)(&Pair::new(&a, &b).expect("a pair")).expect("values")[y * a.width + x];
    let shown = browser.text("document.querySelector('tr.map td').textContent").replace('−', "-");
    let off = shown.parse::<f32>().expect("a number") - value;
    assert!(off.abs() < 1e-4 * value.abs(), "{shown}, not {value}");
    browser.pointer(&[(400.0, 300.0), (450.0, 300.0), (500.0, 300.0)], 8, 0.0);
    assert!(state(&mut browser, "line").as_array().is_some_and(|line| line.len() == 4 && line[1] == line[3]));
    // The address holds all of it, and opens it again.
    browser.key("v");
    browser.eval("ltsc.state.set({ layout: 'side', ev: -1.5, channel: 'g' })");
    browser.settle();
    browser.until("location.hash === ltsc.state.link()");
    let (link, whole) = (browser.text("location.hash"), browser.eval("({ ...ltsc.state.now })"));
    browser.open(index, &link);
    assert_eq!(browser.eval("({ ...ltsc.state.now })"), whole);
    // What an address says wrongly is not taken.
    browser.open(index, "#view?scene=nowhere&a=x&b=y&map=z&zoom=abc&ev=1e99&line=1,2&layout=%3Cb%3E");
    assert_eq!(state(&mut browser, "ev"), 40.0);
    assert_eq!(
        [state(&mut browser, "layout"), state(&mut browser, "map"), state(&mut browser, "line")],
        [json!("single"), json!("signed"), Value::Null]
    );
    // The sheet lists every key that does something.
    browser.key("?");
    let sheet = browser.text("document.querySelector('dialog.sheet').textContent");
    for word in ["stop brighter", "flip between A and B", "verdict on tiles", "this sheet"] {
        assert!(sheet.contains(word), "{sheet}");
    }
    browser.eval("document.querySelector('dialog.sheet').close()");
    browser.key("i");
    browser.until("document.querySelector('main.index') !== null");
    quiet(&mut browser);
}

#[test]
fn tiles_and_files_are_as_shown() {
    let stage = Stage::real();
    let index = stage.report("real");
    let Some(mut browser) = Browser::start("tiles_and_files_are_as_shown", WINDOW) else { return };
    browser.open(&index, &view("&zoom=12&ev=0"));
    let before = canvas(&mut browser).2;
    browser.key("v");
    let (width, _, after) = canvas(&mut browser);
    assert!(before.iter().zip(&after).filter(|(one, other)| one != other).count() > 1000, "tiles are drawn");
    // Each tile has a frame in the color of its verdict.
    let origin = browser.eval("ltsc.draw.place(ltsc.draw.panes()[0]).origin");
    let words = model(&index)["scenes"][0]["pairs"][0]["tiles"]["words"].clone();
    let at = |pixel: usize, axis: usize| ((pixel as f64 - origin[axis].as_f64().expect("a number")) * 12.0) as usize;
    let mut checked = 0;
    for (row, column) in (1..7).flat_map(|row| (1..7).map(move |column| (row, column))) {
        let word = words[row * 8 + column].as_str().expect("a word");
        let color = after[(at(row * 36 / 8, 1) + 1) * width + at(column * 48 / 8, 0) + 30];
        if word == "undecided" {
            assert!(color[0] > 200 && color[1] > 150 && color[2] < 120, "{row}, {column}: {color:?}");
            checked += 1;
        }
    }
    assert!(checked > 0, "some are undecided: {words}");
    // What is to blame: all else is darkened.
    let pair = &model(&index)["scenes"][0]["pairs"];
    let at = pair
        .as_array()
        .expect("pairs")
        .iter()
        .position(|pair| pair["blame"].as_array().is_some_and(|all| !all.is_empty()));
    let at = at.expect("a difference whose place is known");
    let (a, b) = (pair[at]["a"].clone(), pair[at]["b"].clone());
    browser.eval(&format!("ltsc.state.set({{ a: {a}, b: {b}, tiles: 0 }})"));
    browser.settle();
    let plain = canvas(&mut browser).2;
    browser.key("b");
    assert_eq!(browser.eval("ltsc.state.now.blame"), 1);
    let dimmed = canvas(&mut browser).2;
    let bright = |pixels: &[[u8; 4]]| pixels.iter().map(|pixel| u64::from(pixel[0]) + u64::from(pixel[1])).sum::<u64>();
    let same = plain.iter().zip(&dimmed).filter(|(one, other)| one == other && one[3] > 0 && one[1] > 20).count();
    assert!(bright(&dimmed) < bright(&plain) && same > 1000, "{same} pixels are as they were");
    let words = pair[at]["blame"][0]["words"].as_str().expect("words");
    assert!(browser.text("document.querySelector('.blame button[aria-pressed=true]').textContent") == words);
    browser.eval("ltsc.state.set({ a: 0, b: 1, blame: 0, tiles: 1 })");
    browser.settle();
    // The picture that is saved is what is on the screen.
    let saved = "(async () => { const c = ltsc.draw.shot(); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
                 const p = ltsc.draw.panes()[0].canvas; const q = p.getContext('2d').getImageData(0, 0, p.width, p.height).data; \
                 let n = 0; for (let i = 0; i < q.length; i += 4) if (q[i + 3] === 255 && (q[i] !== d[i] || q[i + 1] !== d[i + 1])) n++; \
                 return [c.width - p.width, c.height - p.height, n]; })()";
    assert_eq!(browser.eval(saved), json!([0, 0, 0]));
    let folder = stage.path("downloads");
    fs::create_dir(&folder).expect("a folder");
    browser.send("Page.setDownloadBehavior", json!({ "behavior": "allow", "downloadPath": folder }));
    let file = |browser: &mut Browser, ending: &str| {
        for _ in 0..500 {
            let found = fs::read_dir(&folder).expect("a folder").filter_map(Result::ok).map(|entry| entry.path());
            if let Some(path) = found.into_iter().find(|path| path.extension().is_some_and(|one| one == ending)) {
                return path;
            }
            browser.eval("new Promise((resolve) => setTimeout(resolve, 20))");
        }
        panic!("no file in {ending} was saved");
    };
    browser.key("s");
    let png = file(&mut browser, "png");
    let picture = image::load_from_memory(&fs::read(png).expect("a file")).expect("PNG").to_rgb8();
    let same = after.iter().zip(picture.pixels()).filter(|(one, other)| one[3] < 255 || one[..3] == other.0).count();
    assert_eq!(same, after.len(), "{} x {}", picture.width(), picture.height());
    // Numbers are saved in full.
    browser.eval("[...document.querySelectorAll('button')].find((one) => one.textContent === 'Save PFM').click()");
    let pfm = file(&mut browser, "pfm");
    let (found, _) = read(&pfm).expect("PFM");
    assert_eq!(found, sides(&stage).1);
    quiet(&mut browser);
}

#[test]
fn many_images_are_loaded_where_they_are_looked_at() {
    let stage = Stage::new();
    for at in 0..50 {
        stage.image(&format!("many/scenes/s/{at:02}.exr"), &ramp(64, 48, 1.0 + at as f32));
    }
    // Some are large enough to come in parts, beside and below each other.
    let large = [("wide", 1000, 150), ("tall", 130, 900)];
    for (scene, width, height) in large {
        stage.image(&format!("many/scenes/{scene}/a.exr"), &ramp(width, height, 1e-3));
        stage.image(&format!("many/scenes/{scene}/b.exr"), &ramp(width, height, 2e-3));
    }
    let index = stage.report("many");
    let Some(mut browser) = Browser::start("many_images_are_loaded_where_they_are_looked_at", WINDOW) else { return };
    browser.open(&index, "");
    assert_eq!(browser.files("/data/"), 1, "the index alone");
    browser.forget();
    browser.open(&index, "#view?scene=s&a=00&b=01");
    assert_eq!(browser.files("/data/"), 3, "the index and two images");
    browser.forget();
    browser.open(&index, "#view?scene=s&a=00&b=01&layout=grid");
    let seen = browser.files("/data/");
    assert!((7..40).contains(&seen), "{seen} files of a grid of 50");
    // Parts come where they are needed, and the whole is exact.
    for (scene, width, height) in large {
        browser.open(&index, &format!("#view?scene={scene}&a=a&b=b&show=map&map=relative&zoom=1"));
        let found = browser.floats("ltsc.draw.values(false).then((v) => v.numbers)");
        assert_eq!(found.len(), 4 * width * height, "{scene}");
        let pair = [1e-3, 2e-3].map(|step| ramp(width, height, step));
        let wanted = (MAPS[2].measure)(&Pair::new(&pair[0], &pair[1]).expect("a pair")).expect("values");
        assert!(found.chunks_exact(4).zip(&wanted).all(|(found, wanted)| (found[0] - wanted).abs() < 1e-3), "{scene}");
        browser.open(&index, &format!("#view?scene={scene}&a=a&b=b&zoom=0.25"));
        assert_eq!(browser.eval("ltsc.store.loaded().length"), 2, "{scene}");
        assert_eq!(browser.eval("ltsc.store.done(ltsc.state.now.b)"), false, "a smaller image of {scene} is enough");
    }
    quiet(&mut browser);
}

#[test]
fn strange_names_and_numbers_are_shown_and_do_nothing() {
    strange_ones("strange_names_and_numbers_are_shown_and_do_nothing", &["signed", "ssim", "hdr-flip"], &["signed"]);
}

#[test]
#[ignore = "long: maps of each strange image"]
fn every_map_of_strange_numbers_is_shown() {
    let all: Vec<&str> = MAPS.iter().map(|map| map.name).collect();
    strange_ones("every_map_of_strange_numbers_is_shown", &all, &all);
}

/// Maps of the strangest numbers, and of the others.
fn strange_ones(test: &str, strangest: &[&str], others: &[&str]) {
    let stage = strange();
    let index = stage.report("all");
    let Some(mut browser) = Browser::start(test, WINDOW) else { return };
    browser.open(&index, "");
    let all = browser.text("document.body.textContent");
    assert!(all.contains(HOSTILE) && all.contains(&"long ".repeat(39)), "{all}");
    assert_eq!(browser.eval("document.querySelectorAll('img[src=x]').length"), 0);
    let wide = browser.eval("document.documentElement.scrollWidth - document.documentElement.clientWidth");
    assert_eq!(wide, 0, "long names do not widen the page");
    browser.eval("[...document.querySelectorAll('.cell a')][0].click()");
    browser.until("document.querySelector('.viewer') !== null");
    browser.settle();
    let find = |label: &str| format!("ltsc.book.images.findIndex((one) => one.label === {})", json!(label));
    let choose = |browser: &mut Browser, a: &str, b: &str, map: &str| {
        browser.eval(&format!(
            "ltsc.state.set({{ a: {}, b: {}, show: 'map', map: '{map}', layout: 'single', mev: null }})",
            find(a),
            find(b)
        ));
        browser.settle();
    };
    let plain = read(&page_image(&stage, HOSTILE)).expect("an image").0;
    for name in ["broken numbers", "all black", "nothing finite", "grey"] {
        let other = read(&page_image(&stage, name)).expect("an image").0;
        let asked = if name == "broken numbers" { strangest } else { others };
        for map in MAPS.iter().filter(|map| asked.contains(&map.name)) {
            for (a, b, one, two) in [(HOSTILE, name, &plain, &other), (name, HOSTILE, &other, &plain)] {
                choose(&mut browser, a, b, map.name);
                let wanted =
                    (map.measure)(&Pair::new(one, two).expect("a pair")).unwrap_or_else(|| vec![f32::NAN; 192]);
                let cpu = a == HOSTILE;
                compare(&mut browser, map.name, &wanted, cpu);
            }
        }
    }
    choose(&mut browser, HOSTILE, "other size", "signed");
    let note = browser.text("document.querySelector('.frame .note').textContent");
    assert!(note.contains("differ in size") && note.contains("16 × 12"), "{note}");
    // A link to it opens it.
    choose(&mut browser, HOSTILE, "grey", "signed");
    let link = browser.text("ltsc.state.link()");
    browser.open(&index, &link);
    assert_eq!(browser.text("ltsc.book.images[ltsc.state.now.a].label"), HOSTILE);
    assert_eq!(browser.eval("document.querySelectorAll('img[src=x]').length"), 0);
    quiet(&mut browser);
    // A file of the data that is missing is told, and the rest goes on.
    let number = browser.eval(&find("grey")).as_u64().expect("a number");
    fs::remove_file(index.with_file_name("data").join(format!("{number}-0.js"))).expect("a file");
    browser.open(&index, &link);
    browser.until(
        "document.querySelector('.frame .note').textContent.includes('is missing') || (ltsc.draw.layout(), false)",
    );
    let empty = Stage::new();
    fs::create_dir(empty.path("empty")).expect("a folder");
    browser.forget();
    browser.open(&empty.report("empty"), "#view?scene=x");
    assert!(browser.text("document.body.textContent").contains("There are no images here"));
    quiet(&mut browser);
}

fn page_image(stage: &Stage, label: &str) -> std::path::PathBuf {
    fn find(folder: &Path, label: &str) -> Option<std::path::PathBuf> {
        fs::read_dir(folder).ok()?.filter_map(Result::ok).map(|entry| entry.path()).find_map(|path| {
            if path.is_dir() {
                return find(&path, label);
            }
            (path.file_stem()?.to_str()? == label).then_some(path)
        })
    }
    find(&stage.path("all/scenes"), label).unwrap_or_else(|| panic!("no file {label}"))
}

/// The accessibility checker axe, where it is installed beside the checkout's other validators.
fn axe() -> Option<String> {
    let file = root().join("target/validators/node_modules/axe-core/axe.min.js");
    fs::read_to_string(file).ok()
}

#[test]
fn nothing_serious_keeps_people_out() {
    let test = "nothing_serious_keeps_people_out";
    let Some(axe) = axe() else { return skip(test, "axe-core in target/validators: see .ci/run") };
    let stage = Stage::real();
    fs::remove_file(stage.path("real/scenes/cbox_classic/shallow.exr")).expect("a file");
    let index = stage.report("real");
    let Some(mut browser) = Browser::start(test, (1280, 720)) else { return };
    for scheme in ["light", "dark"] {
        let feature = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        browser.send("Emulation.setEmulatedMedia", feature);
        let places = [
            (String::new(), "[...document.querySelectorAll('details')].forEach((one) => (one.open = true))"),
            (
                view("&show=map&tiles=1&pin=20,20"),
                "[...document.querySelectorAll('details')].forEach((one) => (one.open = true))",
            ),
            (view("&layout=grid&tone=false"), "0"),
            (view(""), "ltsc.sheet()"),
        ];
        for (hash, before) in places {
            browser.open(&index, &hash);
            browser.eval(&format!("{before}; 0"));
            browser.eval(&format!("{axe}; 0"));
            let found = browser.eval(
                "axe.run(document, { resultTypes: ['violations'] }).then((r) => r.violations.map((v) => ({ id: v.id, impact: v.impact, \
                 help: v.help, nodes: v.nodes.slice(0, 3).map((n) => n.html.slice(0, 200) + ' ' + n.failureSummary) })))",
            );
            let serious = |one: &&Value| matches!(one["impact"].as_str(), Some("serious" | "critical" | "moderate"));
            let serious: Vec<&Value> = found.as_array().expect("a list").iter().filter(serious).collect();
            assert!(serious.is_empty(), "{scheme} {hash}: {serious:#?}");
        }
    }
    // Everything can be reached by the keyboard alone: the first link, and the panes.
    browser.open(&index, &view(""));
    let reached = browser.eval(
        "[...document.querySelectorAll('a, button, select, input, summary, [tabindex]')].every((one) => one.tabIndex >= 0 || one.closest('[hidden]'))",
    );
    assert_eq!(reached, true);
}
