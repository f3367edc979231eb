//! The pinhole camera.

use super::{Vec3, cross, normalized, sub};

/// A pinhole camera that looks from `eye` to `target`. The image is not mirrored: what lies to the right of the viewing
/// direction (`(target - eye) x up`) is on the right of the image.
///
/// Spelling: Mitsuba `perspective` with `fov`, `fovAxis` x and `lookat`; PBRT `Camera "perspective"` with `fov` along the
/// shorter axis behind `Scale -1 1 1` and `LookAt`; LuxCore `scene.camera` with `screenwindow`; glTF a camera node with
/// `yfov` and `aspectRatio`.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// None for the only camera of a scene.
    pub name: Option<String>,
    /// Position.
    pub eye: Vec3,
    /// A point on the optical axis, not equal to `eye`.
    pub target: Vec3,
    /// A direction not parallel to `target - eye`; needs no unit length.
    pub up: Vec3,
    /// Full horizontal angle of view in degrees, 0 < fov_x < 180.
    pub fov_x: f64,
    /// Near clipping distance along the axis, > 0; none leaves it to the scene's bounds.
    pub near: Option<f64>,
    /// Far clipping distance along the axis, > near; none leaves it to the scene's bounds.
    pub far: Option<f64>,
}

/// The unit axes of a camera: right, up and forward, so that right x up = -forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    /// To the right of the image.
    pub right: Vec3,
    /// To the top of the image.
    pub up: Vec3,
    /// Along the optical axis.
    pub forward: Vec3,
}

impl Camera {
    /// Its axes; none where its directions are degenerate, which validation refuses.
    pub fn axes(&self) -> Option<Axes> {
        let forward = normalized(sub(self.target, self.eye))?;
        let right = normalized(cross(forward, normalized(self.up)?))?;
        Some(Axes { right, up: cross(right, forward), forward })
    }
}
