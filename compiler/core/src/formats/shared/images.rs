//! Image files of targets: the scene's own where a target reads it as it is meant, else one in another form in the target's folder.

use std::io;

use crate::files::Sink;
use crate::formats::{self, Emission};
use crate::image::{self, sphere, write};
use crate::ir::{Encoding, Handle, LightKind, Scene, Texture};

/// What an image is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Use {
    /// It colors surfaces.
    Surface,
    /// It is the environment, with this tint.
    Sky([f64; 3]),
}

/// How a target gets an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// As the scene has it, in the folder that targets share.
    Shared,
    /// Its linear values as half floats in OpenEXR.
    Decoded,
    /// Its codes in PNG.
    Png,
    /// Its numbers in a portable float map.
    Pfm,
    /// Its linear values times this as floats in OpenEXR.
    Tinted([f64; 3]),
    /// The same with a row between each two rows and one at each pole.
    Rows([f64; 3]),
    /// The same on an equal-area octahedron.
    Octahedral([f64; 3]),
    /// Not at all.
    None,
}

impl Form {
    /// The ending of its files; none for what is no file of the target's.
    fn ending(self) -> Option<&'static str> {
        match self {
            Self::Shared | Self::None => None,
            Self::Decoded | Self::Tinted(_) | Self::Rows(_) | Self::Octahedral(_) => Some("exr"),
            Self::Png => Some("png"),
            Self::Pfm => Some("pfm"),
        }
    }

    /// By what its numbers are multiplied.
    pub fn factor(self) -> [f64; 3] {
        match self {
            Self::Shared | Self::Decoded | Self::Png | Self::Pfm | Self::None => [1.0; 3],
            Self::Tinted(factor) | Self::Rows(factor) | Self::Octahedral(factor) => factor,
        }
    }

    /// How its numbers become linear.
    pub fn encoding(self, texture: &Texture) -> Encoding {
        match self {
            Self::Shared | Self::Png | Self::Pfm | Self::None => texture.encoding,
            Self::Decoded | Self::Tinted(_) | Self::Rows(_) | Self::Octahedral(_) => Encoding::Linear,
        }
    }

    /// Whether its file holds floats, which are linear in every renderer.
    pub fn holds_floats(self, texture: &Texture) -> bool {
        match self {
            Self::Shared | Self::None => texture.image.format.is_float(),
            Self::Png => false,
            Self::Pfm | Self::Decoded | Self::Tinted(_) | Self::Rows(_) | Self::Octahedral(_) => true,
        }
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// The image cannot be decoded.
    pub fn write(self, texture: &Texture) -> io::Result<Vec<u8>> {
        let bytes = match self {
            Self::Shared | Self::None => texture.file.to_vec(),
            Self::Decoded => write::exr(&image::linear(texture)?, write::Depth::Half)?,
            Self::Png => write::png(&image::stored(texture)?, if texture.image.bits > 8 { 16 } else { 8 })?,
            Self::Pfm => write::pfm(&image::stored(texture)?),
            // Not every renderer reads files of one channel.
            Self::Tinted(factor) => write::exr(&image::linear(texture)?.colored().times(factor), write::Depth::Full)?,
            Self::Rows(factor) => {
                let sky = sphere::between_rows(image::linear(texture)?.times(factor));
                write::exr(&sky, write::Depth::Full)?
            }
            Self::Octahedral(factor) => {
                let side = sphere::side([texture.image.width, texture.image.height]);
                let sky = sphere::octahedral(&image::linear(texture)?, side);
                write::exr(&sky.colored().times(factor), write::Depth::Full)?
            }
        };
        Ok(bytes)
    }
}

/// What a target does with an image.
pub type Forms = fn(&Texture, Use) -> Form;

/// A tint as a number and a color whose largest channel is 1, for targets that have a word for the one only.
pub fn split(tint: [f64; 3]) -> (f64, [f64; 3]) {
    let most = tint.into_iter().fold(0.0, f64::max);
    if most > 0.0 { (most, tint.map(|part| part / most)) } else { (0.0, [1.0; 3]) }
}

/// The image of the environment and its tint; none where there is none.
pub fn sky(scene: &Scene) -> Option<(Handle<Texture>, Use)> {
    scene.lights.values().find_map(|light| {
        let texture = light.kind.texture()?;
        Some((texture, Use::Sky(light.kind.color().rgb())))
    })
}

/// Which images color surfaces, by their places in the arena.
pub fn on_surfaces(scene: &Scene) -> Vec<bool> {
    let mut used = vec![false; scene.textures.len()];
    for texture in scene.materials.values().filter_map(|material| material.bsdf.texture()) {
        used[texture.index()] = true;
    }
    used
}

/// Every use of an image.
pub fn uses(scene: &Scene) -> impl Iterator<Item = (Handle<Texture>, Use)> {
    let surfaces = on_surfaces(scene);
    let surfaces = scene.textures.iter().map(|(handle, _)| handle).filter(move |handle| surfaces[handle.index()]);
    surfaces.map(|handle| (handle, Use::Surface)).chain(sky(scene))
}

/// The name of an image's file within the target's folder; none where it is shared or not there.
fn own(scene: &Scene, texture: Handle<Texture>, purpose: Use, form: Form) -> Option<String> {
    let ending = form.ending()?;
    Some(match purpose {
        // A scene has one environment.
        Use::Sky(_) => format!("environment.{ending}"),
        Use::Surface => {
            let files = formats::texture_files(scene);
            let stem = files[texture.index()].rsplit_once('.').map_or("", |(stem, _)| stem);
            format!("images/{stem}.{ending}")
        }
    })
}

/// The path of an image, seen from the target's folder; none where the target does not have it.
pub fn path(emission: &Emission<'_>, texture: Handle<Texture>, purpose: Use, forms: Forms) -> Option<String> {
    let form = forms(&emission.scene.textures[texture], purpose);
    match form {
        Form::None => None,
        Form::Shared => {
            Some(format!("{}{}", emission.textures, formats::texture_files(emission.scene)[texture.index()]))
        }
        Form::Decoded | Form::Png | Form::Pfm | Form::Tinted(_) | Form::Rows(_) | Form::Octahedral(_) => {
            own(emission.scene, texture, purpose, form)
        }
    }
}

/// The name of an image's file without its folder; none where the target does not have it.
pub fn file_name(scene: &Scene, texture: Handle<Texture>, purpose: Use, forms: Forms) -> Option<String> {
    let form = forms(&scene.textures[texture], purpose);
    if form == Form::None {
        return None;
    }
    let own = own(scene, texture, purpose, form).map(|path| path.rsplit('/').next().unwrap_or_default().to_owned());
    own.or_else(|| formats::texture_files(scene).get(texture.index()).cloned())
}

/// Which images a target has from the folder that targets share.
pub fn shared(scene: &Scene, forms: Forms) -> Vec<bool> {
    let mut shared = vec![false; scene.textures.len()];
    for (texture, purpose) in uses(scene) {
        shared[texture.index()] |= forms(&scene.textures[texture], purpose) == Form::Shared;
    }
    shared
}

/// Writes the images that a target has in a form of its own.
pub fn write_own(scene: &Scene, forms: Forms, sink: &mut dyn Sink) -> io::Result<()> {
    for (handle, purpose) in uses(scene) {
        let texture = &scene.textures[handle];
        let form = forms(texture, purpose);
        if let Some(path) = own(scene, handle, purpose, form) {
            let bytes = form.write(texture)?;
            sink.file(&path, &mut |out| out.write_all(&bytes))?;
        }
    }
    Ok(())
}

/// The path of the image of an environment, likewise.
pub fn sky_path(emission: &Emission<'_>, kind: &LightKind, forms: Forms) -> Option<String> {
    path(emission, kind.texture()?, Use::Sky(kind.color().rgb()), forms)
}

/// The form of an image on surfaces for targets without a word for its factor: `form` where it has none.
pub fn on_surface(texture: &Texture, form: Form) -> Form {
    if texture.is_scaled() { Form::Tinted(texture.factor) } else { form }
}

/// What every target that reads all formats does: the scene's own file, unless it has a factor.
pub fn shared_or_scaled(texture: &Texture, purpose: Use) -> Form {
    match purpose {
        Use::Surface => on_surface(texture, Form::Shared),
        Use::Sky(_) => Form::Shared,
    }
}

/// The scene's own file, for targets that have a word for its factor.
pub fn all_shared(_: &Texture, _: Use) -> Form {
    Form::Shared
}
