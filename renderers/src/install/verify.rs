//! Proves that an installed renderer works: it renders a scene whose image is known.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use super::InstallError;
use crate::image::Image;
use crate::run::{Driver, RenderRequest, TEST_SCENE, render};

/// The first start of a renderer on a slow disk.
const TIME: Duration = Duration::from_secs(300);
/// For the mean over the diffuse quarter, about twenty standard deviations of 64 samples in 16
/// pixels (0.0115 / 4 of 0.5, measured with Mitsuba 3.9.1; LuxCore has a fourth of that).
const NOISY: f32 = 0.12;
/// The precision of numbers that a renderer hands over as they are (measured with the test scene: they are exact).
const EXACT: f32 = 1e-4;
/// How many times the samples a renderer takes that computes with wavelengths, and how far its colors may be off: the lamp
/// of the test scene by 0.014 in red (pbrt-r4 4.5.2).
const SPECTRAL: u32 = 256;
const SPECTRAL_COLOR: f32 = 0.02;

/// Renders the driver's test scene in a folder beside the installation and compares it with what
/// [`TEST_SCENE`] says. Gives the version of the renderer.
pub(super) fn verify(
    driver: &'static Driver,
    executable: &Path,
    folder: &Path,
    cancel: Option<Arc<AtomicBool>>,
) -> Result<String, InstallError> {
    let scene = folder.join("test-scene");
    fs::create_dir_all(&scene).map_err(InstallError::io(&scene))?;
    for (name, text) in driver.test_scene {
        let path = scene.join(name);
        fs::write(&path, text).map_err(InstallError::io(&path))?;
    }
    let (width, height, samples) = TEST_SCENE;
    let mut request = RenderRequest::new(driver, scene.clone(), (width, height), folder.join("test-scene.log"));
    request.executable = Some(executable.to_owned());
    request.samples = samples * if driver.wavelengths.is_some() { SPECTRAL } else { 1 };
    // LuxCore 2.11.2 adds samples of several threads to a pixel without a lock: in an image this small an update is lost
    // now and then (measured: a pixel of radiance 1 came out as 199/198).
    request.threads = Some(1);
    request.timeout = Some(TIME);
    request.cancel = cancel;
    let rendered = render(&request, &mut |_| {}).map_err(|error| InstallError::Render(Box::new(error)))?;
    let precision = precision(driver, request.samples);
    judge(&rendered.image, precision).map_err(|message| InstallError::Wrong { driver, message })?;
    // What stays is of no further use.
    let _ = fs::remove_dir_all(&scene);
    Ok(rendered.renderer_version)
}

/// How exactly what is seen directly must be right in each channel: six standard deviations where wavelengths are noise.
pub(super) fn precision(driver: &Driver, samples: u32) -> [f32; 3] {
    match driver.wavelengths {
        None => [EXACT; 3],
        Some([red, green, blue, _]) => {
            [red, green, blue].map(|share| SPECTRAL_COLOR + 6.0 * share as f32 / (samples as f32).sqrt())
        }
    }
}

/// Compares an image with [`TEST_SCENE`]; what is seen directly must be right within `precision`.
pub(super) fn judge(image: &Image, precision: [f32; 3]) -> Result<(), String> {
    let (columns, rows) = (image.width / 2, image.height / 2);
    let surface = [0.5, 0.25, 0.125];
    let mut mean = [0.0; 3];
    for y in 0..image.height {
        for x in 0..image.width {
            let pixel = image.at(x, y);
            let wanted = match (x < columns, y < rows) {
                (true, true) => [1.0, 2.0, 4.0],
                (false, false) => {
                    for (sum, value) in mean.iter_mut().zip(pixel) {
                        *sum += value / (columns * rows) as f32;
                    }
                    continue;
                }
                _ => [1.0; 3],
            };
            if !close(pixel, wanted, precision) {
                return Err(format!("pixel ({x}, {y}) of the test scene is {pixel:?} instead of {wanted:?}"));
            }
        }
    }
    if !close(mean, surface, [NOISY; 3]) {
        return Err(format!("the diffuse surface of the test scene has mean {mean:?} instead of {surface:?}"));
    }
    Ok(())
}

/// Whether each channel lies within a share of what it should be; not so if it is not a number.
fn close(found: [f32; 3], wanted: [f32; 3], shares: [f32; 3]) -> bool {
    found.iter().zip(wanted).zip(shares).all(|((found, wanted), share)| (found - wanted).abs() <= share * wanted)
}
