//! What is printed is read back as the same.

use std::time::Duration;

use ltsc_core::diag::{Sources, Span};
use ltsc_core::ir::Filter;
use proptest::prelude::*;

use super::model::{At, Budget, Parameter, Reference, Settings, Source, Value};
use super::written::{
    Against, Exclude, Overriding, Parameters, Written, WrittenCase, WrittenCompare, WrittenOutput, WrittenRenderer,
    WrittenScene, WrittenSweep, without_places,
};
use super::{print, read};

fn nowhere() -> Span {
    Span::new(Sources::default().add("x", ""), 0, 0)
}

fn at<T>(value: T) -> At<T> {
    At::new(value, nowhere())
}

fn maybe<S: Strategy>(of: S) -> impl Strategy<Value = Option<At<S::Value>>>
where
    S::Value: Clone,
{
    prop::option::of(of.prop_map(at))
}

/// Any text, also one that needs to be quoted.
fn text() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("a \"b\" \\ c".to_owned()),
        Just("é\u{7f}\u{1}\n\t'''".to_owned()),
        "[a-zA-Z_.-]{0,12}",
        any::<String>()
    ]
}

/// A name: not empty, in one line.
fn word() -> impl Strategy<Value = String> {
    prop_oneof![Just("a \"b\" \\ c".to_owned()), Just("small, lamp=2".to_owned()), "[a-zA-Z_é-][a-zA-Z0-9_. -]{0,10}"]
}

fn words() -> impl Strategy<Value = Vec<At<String>>> {
    prop::collection::vec(word().prop_map(at), 1..4)
}

/// Keys of tables, which stand once.
fn keyed<S: Strategy>(of: S) -> impl Strategy<Value = Vec<(At<String>, S::Value)>>
where
    S::Value: Clone,
{
    prop::collection::btree_map(word().prop_filter("a word of ours", |word| word != "base"), of, 0..4)
        .prop_map(|map| map.into_iter().map(|(key, value)| (at(key), value)).collect())
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.5), Just(-0.0), Just(1e300), Just(1e-7), Just(3.0), prop::num::f64::NORMAL]
}

fn value() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        any::<bool>().prop_map(Value::Bool),
        any::<i64>().prop_map(Value::Integer),
        number().prop_map(Value::Float),
        text().prop_map(Value::String)
    ];
    leaf.prop_recursive(2, 8, 4, |inner| prop::collection::vec(inner, 1..4).prop_map(Value::List))
}

fn parameter() -> impl Strategy<Value = Parameter> {
    let name = prop_oneof![Just("type".to_owned()), Just("n".to_owned()), text()];
    (name, prop::option::of(prop_oneof![Just(String::new()), text()]), value()).prop_map(|(name, kind, value)| {
        // In a table `type` is the statement's own, so that it has always a type.
        let kind = kind.or((name == "type").then(String::new));
        Parameter { name, kind, value, span: nowhere() }
    })
}

fn parameters() -> impl Strategy<Value = Parameters> {
    let base = prop_oneof![Just(Vec::new()), words()];
    (base, keyed(prop::collection::vec(parameter(), 0..4)))
        .prop_map(|(base, statements)| Parameters { base, statements })
}

fn time() -> impl Strategy<Value = Duration> {
    prop_oneof![(1_u64..100_000).prop_map(Duration::from_secs), (1_u64..100_000_000).prop_map(Duration::from_millis)]
}

fn settings() -> impl Strategy<Value = Settings> {
    let filter = prop_oneof![
        (1e-3..10.0).prop_map(|radius| Filter::Box { radius }),
        Just(Filter::Box { radius: 0.5 }),
        (1e-3..10.0, 1e-3..10.0).prop_map(|(stddev, radius)| Filter::Gaussian { stddev, radius })
    ];
    let counts = (maybe(1_u32..), maybe(1_u32..), maybe(any::<u32>()));
    let size = maybe((1_u32..=65_536, 1_u32..=65_536));
    let algorithm = maybe(prop::sample::select(ltsc_core::ir::Integrator::WORDS.to_vec()));
    let points = maybe(prop::sample::select(ltsc_core::ir::Sampler::WORDS.to_vec()));
    (algorithm, points, maybe(filter), counts, size).prop_map(
        |(integrator, sampler, filter, (max_depth, samples, seed), size)| Settings {
            integrator,
            max_depth,
            samples,
            sampler,
            filter,
            size,
            seed,
        },
    )
}

fn overriding(parameters: impl Strategy<Value = Parameters>) -> impl Strategy<Value = Overriding> {
    let budget = (maybe(time()), maybe(1_u32..)).prop_map(|(time, samples)| Budget { time, samples });
    (parameters, settings(), budget, maybe(1_u32..=4096))
        .prop_map(|(parameters, settings, budget, chunks)| Overriding { parameters, settings, budget, chunks })
}

fn reference() -> impl Strategy<Value = Reference> {
    prop_oneof![
        Just(Reference::Nothing),
        Just(Reference::Convention),
        Just(Reference::File("refs/{scene}/{target}.exr".to_owned())),
        "[a-z \"]{0,5}[a-z]".prop_map(Reference::File),
        (word(), prop::option::of(word())).prop_map(|(case, renderer)| Reference::Case { case, renderer })
    ]
}

fn scene() -> impl Strategy<Value = WrittenScene> {
    let source = word().prop_map(|text| {
        let file = text.contains(['/', '\\']) || text.ends_with(".lts");
        at(if file { Source::File(text) } else { Source::Name(text) })
    });
    let expression =
        prop_oneof![Just("45deg".to_owned()), Just("1.0".to_owned()), any::<i64>().prop_map(|n| n.to_string()), word()];
    (source, maybe(word()), keyed(expression), maybe(word()), maybe(reference()))
        .prop_map(|(source, name, set, camera, reference)| WrittenScene { source, name, set, camera, reference })
}

fn renderer() -> impl Strategy<Value = WrittenRenderer> {
    let line = || prop::collection::vec(text().prop_filter("no argument", |text| !text.contains('\0')), 0..3);
    (maybe(word()), maybe(word()), line(), maybe(line()), maybe(1_u32..=1024), maybe(time()), any::<bool>()).prop_map(
        |(target, path, options, command, threads, timeout, manual)| WrittenRenderer {
            name: at(String::new()),
            target,
            path,
            options,
            command,
            threads,
            timeout,
            manual,
        },
    )
}

fn case() -> impl Strategy<Value = WrittenCase> {
    (
        word(),
        maybe(text()),
        words(),
        prop::option::of(words()),
        overriding(parameters()),
        keyed(overriding(parameters())),
        maybe(reference()),
    )
        .prop_map(|(name, description, renderers, scenes, all, one, reference)| WrittenCase {
            name: at(name),
            description,
            renderers,
            scenes,
            all,
            one,
            reference,
            span: nowhere(),
        })
}

fn compare() -> impl Strategy<Value = WrittenCompare> {
    let against = maybe(prop::sample::select(Against::WORDS.map(|(_, against)| against).to_vec()));
    let pairs = prop::collection::vec((word(), word()).prop_map(at), 0..3);
    (against, pairs, maybe(1e-6..0.99), maybe(1e-6..0.99), maybe(prop::sample::select(vec![1_u32, 2, 4, 8]))).prop_map(
        |(against, pairs, tolerance, mean_tolerance, tiles)| WrittenCompare {
            against,
            pairs,
            tolerance,
            mean_tolerance,
            tiles,
        },
    )
}

fn written() -> impl Strategy<Value = Written> {
    let switch = || prop::option::of(any::<bool>());
    let output = (maybe(word()), switch(), switch(), switch())
        .prop_map(|(folder, dated, page, display)| WrittenOutput { folder, dated, page, display });
    let values = prop::collection::btree_set((-1000_i32..1000).prop_map(|number| number.to_string()), 1..5);
    let sweep = (word(), prop::option::of(words()), values).prop_map(|(parameter, scenes, values)| WrittenSweep {
        parameter: at(parameter),
        scenes,
        values: values.into_iter().collect(),
        span: nowhere(),
    });
    let exclude = (words(), prop::option::of(words()), prop::option::of(words()))
        .prop_map(|(scenes, cases, renderers)| Exclude { scenes: Some(scenes), cases, renderers, span: nowhere() });
    let top = (maybe(word()), maybe(text()), output, prop::collection::vec(scene(), 1..4));
    let below = (
        prop::collection::vec(sweep, 0..3),
        keyed(renderer()),
        keyed(parameters()),
        prop::collection::vec(case(), 1..4),
        prop::collection::vec(exclude, 0..3),
    );
    let none = Just(Parameters::default());
    (top, below, overriding(none), maybe(reference()), compare()).prop_map(
        |((name, description, output, scenes), (sweeps, renderers, sets, cases, excludes), all, reference, compare)| {
            Written {
                name,
                description,
                output,
                scenes: Some(at(scenes)),
                sweeps,
                all,
                renderers: renderers.into_iter().map(|(name, renderer)| WrittenRenderer { name, ..renderer }).collect(),
                sets,
                cases,
                excludes,
                reference,
                compare,
            }
        },
    )
}

#[test]
fn what_is_printed_is_read_back_as_the_same() {
    let config = ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() };
    proptest::test_runner::TestRunner::new(config)
        .run(&written(), |given| {
            let text = print(&given);
            let (again, findings) = read(Sources::default().add("a.toml", text.as_str()), &text);
            prop_assert!(findings.is_empty(), "{findings:?}\n{text}");
            prop_assert_eq!(without_places(again, nowhere()), without_places(given, nowhere()), "{}", text);
            Ok(())
        })
        .expect("the same");
}
