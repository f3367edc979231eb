//! Lights without a surface as calls of their constructors.

use super::notes::Notes;
use super::number::{angle, direction, number, vector};
use super::place::{few_digits, matrix, stages};
use super::surface::{Place, color};
use crate::diag::Origin;
use crate::ir::{Affine, Color, ColorOrTexture, Handle, LightKind, Meaning, Scene, Texture, Vec3, normalized};

/// The call of a light; none for one that the language cannot say, which is a finding. `texture` writes the call of an image.
pub(super) fn light(
    notes: &mut Notes,
    scene: &Scene,
    name: &str,
    kind: &LightKind,
    at: &Origin,
    texture: &dyn Fn(Handle<Texture>) -> String,
) -> Option<String> {
    let name = name.escape_debug();
    let strength = |notes: &mut Notes, value: &Color| {
        let what = format!("the strength of the light `{name}`");
        color(notes, value, &Place { at, what: &what, meaning: Meaning::Light, least: 0.0 })
    };
    let point = |notes: &mut Notes, position: &Vec3| {
        vector(&notes.finite(at, &format!("the position of the light `{name}`"), *position))
    };
    match kind {
        LightKind::Environment { radiance: ColorOrTexture::Texture(image), tint, turn } => {
            environment(notes, scene, *image, (tint, turn), at, &texture(*image))
        }
        LightKind::Environment { radiance: ColorOrTexture::Color(radiance), tint, turn: _ } => {
            if *tint == Color::Grey(1.0) {
                return Some(format!("environment(radiance: {})", strength(notes, radiance)));
            }
            notes.baked(at, "the tint of an environment without an image is multiplied into its color");
            let (one, other) = (radiance.rgb(), tint.rgb());
            let product = Color::Rgb([0, 1, 2].map(|channel| one[channel] * other[channel]));
            Some(format!("environment(radiance: {})", strength(notes, &product)))
        }
        LightKind::Point { position, intensity } => {
            let (position, intensity) = (point(notes, position), strength(notes, intensity));
            Some(format!("point(position: {position}, intensity: {intensity})"))
        }
        LightKind::Spot { position, target, intensity, angle: outer, inner } => {
            if position == target {
                notes.dropped(at, format!("the spot `{name}` is left out: it shines nowhere"));
                return None;
            }
            let (position, target) = (point(notes, position), point(notes, target));
            let intensity = strength(notes, intensity);
            let what = format!("the angle of the spot `{name}`");
            let outer = notes.within(at, &what, *outer, f64::MIN_POSITIVE, 90.0);
            let inner = notes.within(at, &what, *inner, 0.0, outer);
            let inner = if inner == outer { String::new() } else { format!(", inner: {}", angle(inner)) };
            let outer = angle(outer);
            Some(format!("spot(position: {position}, target: {target}, intensity: {intensity}, angle: {outer}{inner})"))
        }
        LightKind::Directional { direction: along, irradiance } => {
            let Some(unit) = normalized(*along) else {
                notes.dropped(at, format!("the light `{name}` is left out: it has no direction"));
                return None;
            };
            let found = before_normalizing(*along).unwrap_or_else(|| {
                let message = format!("the direction of the light `{name}` is written to the last place but one");
                notes.changed(at, message);
                unit
            });
            let irradiance = strength(notes, irradiance);
            Some(format!("directional(direction: {}, irradiance: {irradiance})", direction(found)))
        }
    }
}

/// An environment with an image.
fn environment(
    notes: &mut Notes,
    scene: &Scene,
    image: Handle<Texture>,
    (tint, turn): (&Color, &Affine),
    at: &Origin,
    call: &str,
) -> Option<String> {
    let texture = &scene.textures[image];
    if !texture.image.format.is_float() {
        let words = texture.image.format.words();
        notes.dropped(at, format!("an environment is left out: its image is {words}, which holds no radiance"));
        return None;
    }
    if texture.is_scaled() {
        notes.dropped(at, "an environment is left out: its image has a factor of its own");
        return None;
    }
    let what = "the tint of the environment";
    let place = Place { at, what, meaning: Meaning::Light, least: 0.0 };
    let tint = match tint {
        Color::Grey(1.0) => String::new(),
        Color::Grey(scale) => format!(", scale: {}", number(notes.within(at, what, *scale, 0.0, f64::MAX))),
        Color::Rgb(_) => format!(", tint: {}", color(notes, tint, &place)),
        Color::Spectrum(spectrum) => {
            notes.changed(at, "the tint of the environment is a spectrum: its color is written");
            format!(", tint: {}", color(notes, &Color::Rgb(spectrum.rgb()), &place))
        }
    };
    let turn = if turn.is_rotation() {
        turned(turn)
    } else {
        notes.dropped(at, "the turn of the environment is left out: it is no rotation");
        String::new()
    };
    Some(format!("environment(radiance: {call}{tint}){turn}"))
}

/// A rotation as stages that environments have.
fn turned(turn: &Affine) -> String {
    let found = stages(turn);
    let turns = found.split(" |> ").skip(1).all(|stage| stage.starts_with("rotate("));
    if turns { found } else { matrix(turn) }
}

/// How many of the numbers next to one are tried.
const STEPS: usize = 8;

/// A vector that becomes `unit`, in every bit, once it is brought to length 1: one of few digits where there is one, else one of
/// those next to `unit`.
fn before_normalizing(unit: Vec3) -> Option<Vec3> {
    let good = |candidate: Vec3| normalized(candidate) == Some(unit);
    if let Some(found) = few_digits(unit, &good).or_else(|| good(unit).then_some(unit)) {
        return Some(found);
    }
    let largest = unit.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
    // The largest part becomes 1 on the way, so that the others decide.
    let steps = |part: f64| {
        let part = part / largest;
        let (mut up, mut down) = (part, part);
        let mut all = vec![part];
        for _ in 0..STEPS {
            (up, down) = (up.next_up(), down.next_down());
            all.extend([up, down]);
        }
        if part == 0.0 || part.abs() == 1.0 { vec![part] } else { all }
    };
    let [x, y, z] = unit.map(steps);
    let all = x.iter().flat_map(|x| y.iter().map(move |y| [*x, *y]));
    let mut all = all.flat_map(|[x, y]| z.iter().map(move |z| [x, y, *z]));
    all.find(|candidate| good(*candidate))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn round_directions_are_found_again() {
        for written in [[1.0, 2.0, -4.0], [0.0, 0.0, -1.0], [0.3, -0.1, -1.0], [-3.0, 0.5, 7.0]] {
            let unit = normalized(written).expect("a direction");
            let found = before_normalizing(unit).expect("there is one");
            assert_eq!(normalized(found), Some(unit));
            assert!(vector(&found).len() <= 30, "{found:?} for {written:?}");
        }
        assert_eq!(before_normalizing([0.0, 0.0, 2.0]), None);
    }

    proptest! {
        #[test]
        fn other_directions_are_found_too(x in -1.0..1.0_f64, y in -1.0..1.0_f64, z in 0.1..1.0_f64) {
            let unit = normalized([x, y, z]).expect("a direction");
            prop_assert_eq!(before_normalizing(unit).and_then(normalized), Some(unit));
        }
    }
}
