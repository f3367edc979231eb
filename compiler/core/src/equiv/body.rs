//! Meshes and their uses in sums that move with them: two uses of the same triangles have the same sums, in whatever order.

use crate::ir::{Affine, Handle, Mesh, Scene, Vec3, cross, dot, length, normalized, sub};
use crate::survey::{Bounds, Placed, Survey};

/// A mesh in sums over the corners of its triangles, each corner counted once for each of them.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its triangles that have an area.
    pub triangles: Vec<[u32; 3]>,
    /// The mean corner.
    mean: Vec3,
    /// The mean of products of coordinates around it: xx, yy, zz, xy, xz, yz as a symmetric matrix.
    spread: [Vec3; 3],
}

impl Body {
    /// That of a mesh; triangles with an index out of range are passed over.
    pub fn of(mesh: &Mesh) -> Self {
        let whole = |triangle: &&[u32; 3]| {
            triangle.iter().all(|index| (*index as usize) < mesh.positions.len()) && {
                let [a, b, c] = mesh.corners(**triangle);
                let (one, other) = (sub(b, a), sub(c, a));
                length(cross(one, other)) > 1e-12 * dot(one, one).max(dot(other, other))
            }
        };
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter(whole).copied().collect();
        let corners = || triangles.iter().flat_map(|triangle| mesh.corners(*triangle));
        let count = (3 * triangles.len()).max(1) as f64;
        let mut mean = [0.0; 3];
        for corner in corners() {
            mean.iter_mut().zip(corner).for_each(|(sum, x)| *sum += x / count);
        }
        let mut spread = [[0.0; 3]; 3];
        for corner in corners() {
            let from = sub(corner, mean);
            for (row, x) in spread.iter_mut().zip(from) {
                row.iter_mut().zip(from).for_each(|(sum, y)| *sum += x * y / count);
            }
        }
        Self { triangles, mean, spread }
    }
}

/// A use of a shape at its place.
#[derive(Clone, Copy, Debug)]
pub struct Use<'s> {
    /// The shape and the instances around it.
    pub placed: &'s Placed<'s>,
    /// How many triangles it has.
    pub count: usize,
    /// The mean corner in the scene.
    pub mean: Vec3,
    /// Products of coordinates around the mean.
    pub spread: [Vec3; 3],
}

impl<'s> Use<'s> {
    fn of(placed: &'s Placed<'s>, bodies: &[Body]) -> Self {
        let body = &bodies[placed.shape.mesh.index()];
        let linear = placed.transform.rows.map(|[x, y, z, _]| [x, y, z]);
        let half = linear.map(|row| body.spread.map(|column| dot(row, column)));
        let spread = half.map(|row| linear.map(|column| dot(row, column)));
        Self { placed, count: body.triangles.len(), mean: placed.transform.point(body.mean), spread }
    }

    /// The sum of squares of the distances from the mean, which does not change when it is turned.
    pub fn size(&self) -> f64 {
        self.spread[0][0] + self.spread[1][1] + self.spread[2][2]
    }

    /// Its box.
    pub fn bounds(&self) -> Bounds {
        self.placed.bounds
    }
}

/// A scene as uses of bodies.
#[derive(Debug)]
pub struct Bodies<'s> {
    /// The scene.
    pub scene: &'s Scene,
    /// By mesh.
    pub bodies: Vec<Body>,
    /// Around meshes in their own coordinates, by mesh.
    pub boxes: &'s [Option<Bounds>],
    /// All uses that have triangles.
    pub uses: Vec<Use<'s>>,
}

impl<'s> Bodies<'s> {
    /// Those of a scene.
    pub fn of(survey: &'s Survey<'s>) -> Self {
        let bodies: Vec<Body> = survey.scene.meshes.values().map(Body::of).collect();
        let uses = survey.placed.iter().map(|placed| Use::of(placed, &bodies)).filter(|one| one.count > 0).collect();
        Self { scene: survey.scene, bodies, boxes: &survey.meshes, uses }
    }

    /// The mesh of a use.
    pub fn mesh(&self, handle: Handle<Mesh>) -> &'s Mesh {
        &self.scene.meshes[handle]
    }

    /// The triangles of a use in the scene, counter-clockwise seen from the front.
    pub fn triangles(&self, one: &Use<'_>) -> impl Iterator<Item = Corners> {
        let mesh = self.mesh(one.placed.shape.mesh);
        let map = one.placed.transform;
        let mirrored = map.determinant() < 0.0;
        let body = &self.bodies[one.placed.shape.mesh.index()];
        body.triangles.iter().map(move |&[a, b, c]| {
            // A mirroring map turns the winding: the front stays the front.
            let indices = if mirrored { [a, c, b] } else { [a, b, c] };
            Corners { indices, at: mesh.corners(indices).map(|corner| map.point(corner)) }
        })
    }

    /// The shading normals at the corners of a triangle of a use, to its front.
    pub fn normals(&self, one: &Use<'_>, corners: &Corners) -> [Vec3; 3] {
        let [a, b, c] = corners.at;
        let flat = normalized(cross(sub(b, a), sub(c, a))).unwrap_or([0.0; 3]);
        let Some(normals) = &self.mesh(one.placed.shape.mesh).normals else { return [flat; 3] };
        let map = one.placed.transform;
        let (rows, sign) = (map.cofactors(), map.determinant().signum());
        corners.indices.map(|index| {
            let normal = normals.get(index as usize).map(|normal| normal.map(f64::from));
            let moved = normal.and_then(|normal| normalized(rows.map(|row| sign * dot(row, normal))));
            moved.unwrap_or(flat)
        })
    }

    /// The texture coordinates at the corners of a triangle of a use; 0 where it has none.
    pub fn uvs(&self, one: &Use<'_>, corners: &Corners) -> [[f64; 2]; 3] {
        let uvs = self.mesh(one.placed.shape.mesh).uvs.as_ref();
        corners
            .indices
            .map(|index| uvs.and_then(|uvs| uvs.get(index as usize)).map_or([0.0; 2], |uv| uv.map(f64::from)))
    }
}

/// A triangle of a use.
#[derive(Clone, Copy, Debug)]
pub struct Corners {
    /// Into the vertices of its mesh.
    pub indices: [u32; 3],
    /// In the scene.
    pub at: [Vec3; 3],
}

impl Corners {
    /// Its middle.
    pub fn middle(&self) -> Vec3 {
        let [a, b, c] = self.at;
        [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0)
    }
}

/// The map from the coordinates of A's mesh to those of B's by which a use of A lies as that of B; none where B's cannot be inverted.
pub fn between(a: &Affine, b: &Affine) -> Option<Affine> {
    crate::formats::shared::reading::inverse(b).map(|back| a.then(&back))
}
