//! Lights without a surface: numbers in range, a direction, one environment.

use crate::diag::Finding;
use crate::ir::{Affine, LightKind, LightSource, Scene, Texture, length};

use super::fits;

pub(super) fn check(scene: &Scene, findings: &mut Vec<Finding>) {
    let mut environment = false;
    for (origin, light) in scene.lights.entries() {
        let LightSource { name, kind } = light;
        let mut fault = |id, message: &str| {
            let message = format!("emitter `{}`: {message}", name.escape_debug());
            findings.push(Finding::error(id, origin.clone(), message));
        };
        if !kind.color().rgb().iter().all(|x| fits(*x) && *x >= 0.0) {
            fault("invalid-light", "its strength is negative, not finite, or beyond 1e30");
        }
        match kind {
            LightKind::Environment { radiance, tint, turn } => {
                let image = radiance.texture().map(|texture| scene.textures.values().nth(texture.index()));
                let unfit = |texture: &Texture| !texture.image.format.is_float() || texture.is_scaled();
                if image.is_some_and(|image| image.is_none_or(unfit)) {
                    fault(
                        "invalid-light",
                        "its image is not in the scene, holds no floats, or has a factor of its own",
                    );
                }
                if !(radiance.texture().is_some() || (tint.is_grey() && tint.max() == 1.0 && *turn == Affine::IDENTITY))
                {
                    fault("invalid-light", "it is tinted or turned without an image");
                }
                if !turn.is_rotation() {
                    fault("invalid-light", "it is turned by something else than a rotation");
                }
                if environment {
                    fault("second-environment", "there is another environment, which Mitsuba refuses");
                }
                environment = true;
            }
            LightKind::Point { position, intensity: _ } => {
                if !position.iter().all(|x| fits(*x)) {
                    fault("invalid-light", "its position is not finite, or beyond 1e30");
                }
            }
            LightKind::Spot { position, target, intensity: _, angle, inner } => {
                let all = position.iter().chain(target);
                if !all.copied().all(fits) || position == target {
                    fault("invalid-light", "its position or target is not finite, beyond 1e30, or both are one");
                }
                if !(*angle > 0.0 && *angle <= 90.0 && (0.0..=*angle).contains(inner)) {
                    fault("invalid-light", "its angles do not fulfil 0 <= inner <= angle <= 90 with an angle above 0");
                }
            }
            LightKind::Directional { direction, irradiance: _ } => {
                // Rounded to single precision in renderers, which normalize it anew.
                let off = (length(*direction) - 1.0).abs();
                if off.is_nan() || off > 1e-6 {
                    fault("invalid-light", "its direction has not length 1");
                }
            }
        }
    }
}
