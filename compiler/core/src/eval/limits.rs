//! How large a scene may become, and how each bound is raised.

/// Bounds on what one scene may make of its text. They keep a slip of the pen, or hostile input, from using up a machine;
/// each may be raised. Two bounds are fixed, since the parser relies on them: [`crate::syntax::NESTING_LIMIT`] and
/// [`crate::syntax::NAME_LIMIT`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of a scene text.
    pub text: u64,
    /// Bytes of a file that a scene names: meshes, images, arrays.
    pub file: u64,
    /// Elements of a list.
    pub list: usize,
    /// Pixels of an image.
    pub pixels: u64,
    /// Calls and iterations, and work that takes as long.
    pub steps: u64,
    /// Bytes that values hold at one time.
    pub memory: u64,
    /// Triangles that generators and stages of a scene make together.
    pub triangles: u64,
    /// Shapes and instances, those in groups counted as often as their group is placed.
    pub instances: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            text: 64 << 20,
            file: 16 << 30,
            list: 1_000_000,
            pixels: 1 << 27,
            steps: 10_000_000,
            memory: 2 << 30,
            triangles: 50_000_000,
            instances: 10_000_000,
        }
    }
}

/// A limit as people name it.
pub struct Limit {
    /// Its name.
    pub name: &'static str,
    /// What it bounds, with its unit.
    pub what: &'static str,
    /// The most that it can be raised to.
    pub most: u64,
    get: fn(&Limits) -> u64,
    set: fn(&mut Limits, u64),
}

impl Limit {
    /// All limits in the order of the manual.
    pub const ALL: &[Self] = &[
        Self {
            name: "text",
            what: "bytes of a scene text",
            // Places in a text are 32-bit numbers.
            most: u32::MAX as u64,
            get: |limits| limits.text,
            set: |limits, value| limits.text = value,
        },
        Self {
            name: "file",
            what: "bytes of a file that a scene names",
            most: 1 << 50,
            get: |limits| limits.file,
            set: |limits, value| limits.file = value,
        },
        Self {
            name: "list",
            what: "elements of a list",
            most: u32::MAX as u64,
            get: |limits| limits.list as u64,
            set: |limits, value| limits.list = value as usize,
        },
        Self {
            name: "pixels",
            what: "pixels of an image that a scene names; reading one takes up to 20 bytes for each",
            most: 1 << 32,
            get: |limits| limits.pixels,
            set: |limits, value| limits.pixels = value,
        },
        Self {
            name: "steps",
            what: "calls and iterations of loops in a scene; 32 parts of expressions or elements of lists count as one",
            most: 1 << 50,
            get: |limits| limits.steps,
            set: |limits, value| limits.steps = value,
        },
        Self {
            name: "memory",
            what: "bytes that lists, spectra, vertices and places of a scene take while it is read",
            most: 1 << 50,
            get: |limits| limits.memory,
            set: |limits, value| limits.memory = value,
        },
        Self {
            name: "triangles",
            what: "triangles that the generators and stages of a scene make",
            most: 1 << 40,
            get: |limits| limits.triangles,
            set: |limits, value| limits.triangles = value,
        },
        Self {
            name: "instances",
            what: "shapes and instances of a scene, those in groups counted as often as their group is placed",
            most: crate::ir::INSTANCE_LIMIT,
            get: |limits| limits.instances,
            set: |limits, value| limits.instances = value,
        },
    ];

    /// The limit called `name`.
    pub fn find(name: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|limit| limit.name == name)
    }

    /// Its value in `limits`.
    pub fn of(&self, limits: &Limits) -> u64 {
        (self.get)(limits)
    }

    /// Sets it.
    ///
    /// # Errors
    /// In words, where `value` is 0 or more than [`Limit::most`].
    pub fn set(&self, limits: &mut Limits, value: u64) -> Result<(), String> {
        if value == 0 || value > self.most {
            return Err(format!("the limit `{}` lies from 1 to {}, not at {value}", self.name, self.most));
        }
        (self.set)(limits, value);
        Ok(())
    }

    /// How to raise it, for the help of a finding.
    pub fn help(name: &str) -> String {
        format!("if this is meant, raise the limit by `--limit {name}=N` or `[limits]` in ltsc.toml")
    }
}

/// A whole number with `_` between its digits and one of the units `KiB`, `MiB`, `GiB` behind it, or none.
pub fn parse_amount(text: &str) -> Option<u64> {
    let units = [("KiB", 10), ("MiB", 20), ("GiB", 30), ("", 0)];
    let (digits, shift) = units.iter().find_map(|(unit, shift)| Some((text.strip_suffix(unit)?, *shift)))?;
    let digits = digits.trim_end();
    if !digits.starts_with(|first: char| first.is_ascii_digit()) {
        return None;
    }
    digits.replace('_', "").parse::<u64>().ok()?.checked_mul(1 << shift)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_whole_numbers_with_units() {
        let all = ["10", "10_000", "64MiB", "16 GiB", "1KiB"].map(parse_amount);
        assert_eq!(all, [Some(10), Some(10_000), Some(64 << 20), Some(16 << 30), Some(1024)]);
        for bad in ["", "-1", "1.5", "1e9", "MiB", "_1", "5 TiB", "99999999999999999999", "99999999999999GiB"] {
            assert_eq!(parse_amount(bad), None, "{bad}");
        }
    }

    #[test]
    fn each_limit_sets_what_it_reads() {
        for (at, limit) in Limit::ALL.iter().enumerate() {
            let mut limits = Limits::default();
            assert!(limit.of(&limits) <= limit.most, "{}", limit.name);
            assert_eq!(limit.set(&mut limits, 7), Ok(()));
            for (other, same) in Limit::ALL.iter().enumerate() {
                let expected = if other == at { 7 } else { same.of(&Limits::default()) };
                assert_eq!(same.of(&limits), expected, "{} changes {}", limit.name, same.name);
            }
            assert!(limit.set(&mut limits, 0).is_err() && limit.set(&mut limits, limit.most + 1).is_err());
        }
    }
}
