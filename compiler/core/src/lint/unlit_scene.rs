//! Rule `unlit-scene`: a scene has light.
#![doc = include_str!("unlit_scene.md")]

use super::{Level, Report, Rule, Subject};

pub(super) const RULE: Rule = Rule {
    id: "unlit-scene",
    level: Level::Deny,
    summary: "Nothing in a scene sends out light.",
    doc: include_str!("unlit_scene.md"),
    targets: &[],
    check,
};

fn check(subject: &Subject<'_>, report: &mut Report) {
    let scene = subject.scene;
    let placed = &subject.survey().placed;
    let emissions = placed.iter().filter_map(|placed| placed.shape.emission.as_ref());
    let strengths =
        emissions.map(|emission| &emission.radiance).chain(scene.lights.values().map(|light| light.kind.color()));
    if strengths.into_iter().any(|color| !color.is_black()) {
        return;
    }
    report.add(
        &scene.origin,
        "nothing in the scene sends out light".to_owned(),
        "this scene",
        "the image is black in every renderer: that they agree on it says nothing",
        "write for example `emitter lamp = rectangle(x: -1..1, y: -1..1, z: 5, normal: -Z) with radiance(10)`"
            .to_owned(),
    );
}
