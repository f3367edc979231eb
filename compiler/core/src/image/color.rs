//! Colors of other primaries in the linear sRGB that everything here means.

/// Where red, green, blue and white of an image lie in the diagram of CIE 1931, as x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Primaries {
    pub red: [f64; 2],
    pub green: [f64; 2],
    pub blue: [f64; 2],
    pub white: [f64; 2],
}

/// Those of Rec. 709, which sRGB and OpenEXR without a word about it have.
pub(super) const REC_709: Primaries =
    Primaries { red: [0.64, 0.33], green: [0.3, 0.6], blue: [0.15, 0.06], white: [0.3127, 0.329] };

/// How far places may be off and still be Rec. 709: files round them, the white above all.
const SAME: f64 = 2e-3;

type Matrix = [[f64; 3]; 3];

/// The responses of the Bradford transform, by which one white becomes another (Lam 1985; Annex E of ICC.1:2022).
const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

impl Primaries {
    /// Whether they are those of Rec. 709 as far as files can tell.
    pub fn is_rec_709(&self) -> bool {
        let places = |from: &Self| [from.red, from.green, from.blue, from.white];
        places(self).as_flattened().iter().zip(places(&REC_709).as_flattened()).all(|(a, b)| (a - b).abs() <= SAME)
    }

    /// The matrix from these to linear sRGB, white to white; none where they span no plane.
    pub fn to_srgb(self) -> Option<Matrix> {
        let adapted = {
            let responses = |white| times(&BRADFORD, xyz(white));
            let (from, to) = (responses(self.white), responses(REC_709.white));
            let scale = [0, 1, 2].map(|row| {
                let mut line = [0.0; 3];
                line[row] = to[row] / from[row];
                line
            });
            product(&inverse(&BRADFORD)?, &product(&scale, &BRADFORD))
        };
        let matrix = product(&inverse(&REC_709.to_xyz()?)?, &product(&adapted, &self.to_xyz()?));
        matrix.as_flattened().iter().all(|part| part.is_finite()).then_some(matrix)
    }

    fn to_xyz(self) -> Option<Matrix> {
        let columns = [self.red, self.green, self.blue].map(xyz);
        let plain: Matrix = [0, 1, 2].map(|row| columns.map(|column| column[row]));
        let weights = times(&inverse(&plain)?, xyz(self.white));
        Some(plain.map(|row| [0, 1, 2].map(|at| row[at] * weights[at])))
    }
}

/// The color of luminance 1 at a place of the diagram.
fn xyz([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

/// A matrix times a column.
pub(super) fn times(matrix: &Matrix, [a, b, c]: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * a + row[1] * b + row[2] * c)
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| [0, 1, 2].map(|at| row[0] * b[0][at] + row[1] * b[1][at] + row[2] * b[2][at]))
}

fn inverse(m: &Matrix) -> Option<Matrix> {
    let cofactor = |row: usize, column: usize| {
        let at = |row: usize, column: usize| m[row % 3][column % 3];
        at(row + 1, column + 1) * at(row + 2, column + 2) - at(row + 1, column + 2) * at(row + 2, column + 1)
    };
    let size: f64 = (0..3).map(|column| m[0][column] * cofactor(0, column)).sum();
    let found = [0, 1, 2].map(|row| [0, 1, 2].map(|column| cofactor(column, row) / size));
    found.as_flattened().iter().all(|part| part.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primaries_of_aces_become_srgb_with_white_kept() {
        let ap1 =
            Primaries { red: [0.713, 0.293], green: [0.165, 0.83], blue: [0.128, 0.044], white: [0.32168, 0.33767] };
        let matrix = ap1.to_srgb().expect("a matrix");
        // As published for ACEScg to linear sRGB with Bradford's adaptation.
        let wanted =
            [[1.705_05, -0.621_79, -0.083_26], [-0.130_26, 1.140_80, -0.010_55], [-0.024_00, -0.128_97, 1.152_97]];
        for (found, wanted) in matrix.as_flattened().iter().zip(wanted.as_flattened()) {
            assert!((found - wanted).abs() < 2e-4, "{matrix:?}");
        }
        assert!(times(&matrix, [0.8; 3]).iter().all(|x| (x - 0.8).abs() < 1e-12));
        assert!(!ap1.is_rec_709() && REC_709.is_rec_709());
    }

    #[test]
    fn primaries_without_a_plane_have_no_matrix() {
        let flat = Primaries { red: [0.3, 0.3], green: [0.3, 0.3], ..REC_709 };
        assert_eq!(flat.to_srgb(), None);
        assert_eq!(Primaries { white: [0.3, 0.0], ..REC_709 }.to_srgb(), None);
    }
}
