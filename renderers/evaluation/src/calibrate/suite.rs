//! What is rendered for the calibration: four scenes, and for each what a wrong agreement or a wrong difference could come from.

/// A scene of the project with the pools that are drawn from.
pub struct Scene {
    /// The name of its file without the ending.
    pub name: &'static str,
    /// Values of its parameters.
    pub set: &'static [(&'static str, &'static str)],
    /// Tolerances at which agreement is looked for, as shares. At these some thousand samples show it.
    pub tolerances: &'static [f64],
    /// The scene written otherwise.
    pub variants: &'static [Variant],
}

/// A scene written otherwise, of which there is a pool of its own.
pub struct Variant {
    /// How it is called, in a word.
    pub name: &'static str,
    /// What it is, for people.
    pub what: &'static str,
    /// What is changed.
    pub change: Change,
    /// Whether the image that its samples tend to is the same.
    pub same: bool,
    /// The seed of its first chunk: pools must not share random numbers.
    pub first_seed: u32,
}

/// What is changed of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// A text that stands in it once becomes another one.
    Text(&'static str, &'static str),
    /// So many lights are added that give next to nothing and take their share of the light samples: the image is the same, the
    /// estimator is much worse.
    DarkLights(u32),
    /// Russian roulette from this segment on, by a native statement: another estimator of the same image.
    Roulette(i64),
}

/// Pixels along each side of all images.
pub const SIZE: u32 = 64;

/// Samples per pixel of a chunk.
pub const SAMPLES: u32 = 16;

const DARK: Variant = Variant {
    name: "dark-lights",
    what: "15 lights more that give nothing and take their share of the light samples",
    change: Change::DarkLights(15),
    same: true,
    first_seed: 10_000,
};

const ROULETTE: Variant = Variant {
    name: "roulette",
    what: "Russian roulette from the second segment on (`rr_depth = 2`)",
    change: Change::Roulette(2),
    same: true,
    first_seed: 20_000,
};

const FOV: Variant = Variant {
    name: "fov",
    what: "`fov_x` 45.2 for 45 degrees",
    change: Change::Text("fov_x: 45deg", "fov_x: 45.2deg"),
    same: false,
    first_seed: 30_000,
};

const DEPTH: Variant = Variant {
    name: "depth",
    what: "`max_depth` 9 for 10",
    change: Change::Text("max_depth: 10", "max_depth: 9"),
    same: false,
    first_seed: 40_000,
};

const ALPHA: Variant = Variant {
    name: "alpha",
    what: "`alpha` 0.07 for 0.0625",
    change: Change::Text("alpha: 0.0625", "alpha: 0.07"),
    same: false,
    first_seed: 50_000,
};

/// All of them.
pub const SCENES: &[Scene] = &[
    Scene { name: "cbox_classic", set: &[], tolerances: &[0.03], variants: &[DARK, ROULETTE, FOV, DEPTH] },
    Scene { name: "ring", set: &[], tolerances: &[0.20], variants: &[DARK, FOV] },
    Scene { name: "pool_simple", set: &[("lamp_side", "40")], tolerances: &[0.15], variants: &[DARK, DEPTH] },
    // At 10 % half of equal pairs agree with more samples than a pool of 1024 chunks has, at 15 % with fewer.
    Scene { name: "veach_mis", set: &[], tolerances: &[0.10, 0.15], variants: &[DARK, FOV, ALPHA] },
];

impl Scene {
    /// The scene with the values of its parameters, for people.
    #[must_use]
    pub fn label(&self) -> String {
        let set: Vec<String> = self.set.iter().map(|(name, value)| format!("{name}={value}")).collect();
        if set.is_empty() { self.name.to_owned() } else { format!("{}, {}", self.name, set.join(", ")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_pools_of_a_scene_share_seeds() {
        for scene in SCENES {
            let mut seeds: Vec<u32> = scene.variants.iter().map(|variant| variant.first_seed).collect();
            seeds.push(0);
            seeds.sort_unstable();
            assert!(seeds.windows(2).all(|pair| pair[1] - pair[0] >= 10_000), "{}: {seeds:?}", scene.name);
        }
    }
}
