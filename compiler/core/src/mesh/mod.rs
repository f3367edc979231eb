//! Generators and mesh arithmetic, and mesh files.
//!
//! One generator or stage per file. Coordinates go in as `f64`, are computed as `f64` and rounded once to the `f32` of
//! the Scene; angles are degrees. A function that gives a [`Geometry`] gives a consistent one: see [`Geometry::check`].

mod boxed;
mod cone;
mod cylinder;
mod disk;
mod error;
mod faceted;
mod faults;
pub mod file;
mod flip;
mod geometry;
mod height_field;
mod lathe;
mod measure;
mod planar;
mod plate;
mod rectangle;
mod revolve;
mod smooth;
mod sphere;
mod split;
mod torus;
mod transform;
mod triangles;

pub use boxed::boxed;
pub use cone::cone;
pub use cylinder::cylinder;
pub use disk::disk;
pub use error::MeshError;
pub use faceted::faceted;
pub use faults::{Faults, Found, duplicate_triangles, faults};
pub use flip::flip;
pub use geometry::Geometry;
pub use height_field::{Field, height_field};
pub use lathe::lathe;
pub use measure::{
    View, area, bounds, degenerate_triangles, face_normal, is_closed, largest_normal_deviation, rim, signed_volume,
};
pub use planar::fewest_triangles;
pub use plate::{Hole, plate};
pub use rectangle::{Axis, Extent, SignedAxis, rectangle};
pub use smooth::{smooth, smooth_groups};
pub use sphere::sphere;
pub use torus::torus;
pub use transform::{transform, transform_normals, transform_positions};
pub use triangles::triangles;

/// The largest number of triangles that a generator makes: three vertices for each have 32-bit indices.
pub const MAX_TRIANGLES: u64 = 1 << 30;

/// How far the length of a normal may be from 1.
pub const UNIT_TOLERANCE: f64 = 1e-3;

/// Whether the vector is finite and its length within [`UNIT_TOLERANCE`] of 1.
pub fn is_unit(normal: [f32; 3]) -> bool {
    let [x, y, z] = normal.map(f64::from);
    // Squared, because roots of millions of normals take time. A NaN lies in no range.
    const LEAST: f64 = (1.0 - UNIT_TOLERANCE) * (1.0 - UNIT_TOLERANCE);
    const MOST: f64 = (1.0 + UNIT_TOLERANCE) * (1.0 + UNIT_TOLERANCE);
    (LEAST..=MOST).contains(&(x * x + y * y + z * z))
}
