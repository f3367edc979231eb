//! Native statements: what a test case gives a target in its own words, in the place of what ltsc writes there.
//!
//! A statement replaces the scene's own of that name whole. Where it goes, and what its parameters look like, each format says in
//! its `statements.rs`; what is not known passes through untouched.

use crate::diag::{Finding, Origin};

/// The code of a finding that a statement cannot be written.
pub const INVALID: &str = "invalid-statement";

/// A value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `true` or `false`.
    Bool(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Float(f64),
    /// A text.
    String(String),
    /// Values of one parameter; lists within lists are refused.
    List(Vec<Value>),
}

impl Value {
    /// The whole number that it is, or that its text says.
    pub fn integer(&self) -> Option<i64> {
        match self {
            Self::Integer(value) => Some(*value),
            Self::String(text) => text.trim().parse().ok(),
            Self::Bool(_) | Self::Float(_) | Self::List(_) => None,
        }
    }

    /// The values of a list, or the one value.
    pub fn items(&self) -> &[Self] {
        match self {
            Self::List(items) => items,
            Self::Bool(_) | Self::Integer(_) | Self::Float(_) | Self::String(_) => std::slice::from_ref(self),
        }
    }
}

/// A parameter of a statement.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name; empty for what PBRT lists without one.
    pub name: String,
    /// Its type in the target's words, empty for what belongs to the statement itself; none where it follows from the value.
    pub kind: Option<String>,
    /// Its value.
    pub value: Value,
}

impl Parameter {
    /// A parameter whose type follows from its value.
    pub fn new(name: impl Into<String>, value: Value) -> Self {
        Self { name: name.into(), kind: None, value }
    }

    /// A parameter of this type: one of the thesis's triples.
    pub fn typed(name: impl Into<String>, kind: impl Into<String>, value: Value) -> Self {
        Self { name: name.into(), kind: Some(kind.into()), value }
    }

    /// Whether it belongs to the statement itself: it has an empty type, or is called `type` and has none.
    pub fn is_own(&self) -> bool {
        self.kind.as_deref().map_or(self.name == "type", str::is_empty)
    }

    /// Its type in the words of a target; none for a list of different or no values whose type is not said.
    pub fn kind<'a>(&'a self, words: &Kinds) -> Option<&'a str> {
        let of = |value: &Value| match value {
            Value::Bool(_) => Some(words.bool),
            Value::Integer(_) => Some(words.integer),
            Value::Float(_) => Some(words.float),
            Value::String(_) => Some(words.string),
            Value::List(_) => None,
        };
        if let Some(kind) = &self.kind {
            return Some(kind);
        }
        let mut kinds = self.value.items().iter().map(of);
        let first = kinds.next()??;
        kinds.try_fold(first, |kind, next| match next? {
            next if next == kind => Some(kind),
            // Whole numbers among others.
            next if [next, kind].iter().all(|kind| [words.integer, words.float].contains(kind)) => Some(words.float),
            _ => None,
        })
    }
}

/// What a target calls the types of values.
#[derive(Debug)]
pub struct Kinds {
    /// `true` or `false`.
    pub bool: &'static str,
    /// Whole numbers.
    pub integer: &'static str,
    /// Numbers.
    pub float: &'static str,
    /// Texts.
    pub string: &'static str,
}

/// A statement in the words of a target.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Its name: `integrator`, `Sampler`, `film.filter`.
    pub name: String,
    /// Its parameters in their order.
    pub parameters: Vec<Parameter>,
    /// Where it is given.
    pub origin: Origin,
}

impl Statement {
    /// A statement without a place.
    pub fn new(name: impl Into<String>, parameters: Vec<Parameter>) -> Self {
        Self { name: name.into(), parameters, origin: Origin::Made }
    }

    /// The value of a parameter that does not belong to the statement itself.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.parameters.iter().find(|one| one.name == name && !one.is_own()).map(|one| &one.value)
    }

    /// Its own type: the text of the parameter `type` that belongs to it.
    pub fn own_type(&self) -> Option<&str> {
        let own = self.parameters.iter().find(|one| one.name == "type" && one.is_own())?;
        if let Value::String(text) = &own.value { Some(text) } else { None }
    }

    /// That it cannot be written.
    pub fn invalid(&self, message: impl std::fmt::Display) -> Finding {
        Finding::error(INVALID, self.origin.clone(), format!("the statement `{}` {message}", self.name))
    }

    /// What is wrong with its values for every target: numbers that are not finite, lists within lists.
    fn values_wrong(&self) -> impl Iterator<Item = Finding> + '_ {
        let wrong = |one: &Value| match one {
            Value::Float(value) => !value.is_finite(),
            Value::List(_) => true,
            Value::Bool(_) | Value::Integer(_) | Value::String(_) => false,
        };
        let wrong = self.parameters.iter().filter(move |one| one.value.items().iter().any(wrong));
        wrong.map(|one| {
            self.invalid(format!(
                "has a parameter `{}` that is neither a finite number nor a text nor a list of them",
                one.name
            ))
        })
    }
}

/// Statements of a test case, each name once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statements(Vec<Statement>);

/// No statements.
pub static NONE: Statements = Statements(Vec::new());

impl Statements {
    /// Adds a statement. Where there is one of that name already, its parameters are added to that one: the later one of a name and
    /// a type counts, which is how parameter sets extend their bases.
    pub fn give(&mut self, statement: Statement) {
        let Some(known) = self.0.iter_mut().find(|known| known.name == statement.name) else {
            let mut new = Statement { parameters: Vec::new(), ..statement.clone() };
            statement.parameters.into_iter().for_each(|one| set(&mut new.parameters, one));
            self.0.push(new);
            return;
        };
        statement.parameters.into_iter().for_each(|one| set(&mut known.parameters, one));
        known.origin = statement.origin;
    }

    /// The statement of a name.
    pub fn find(&self, name: &str) -> Option<&Statement> {
        self.0.iter().find(|statement| statement.name == name)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All, in the order in which they were given.
    pub fn iter(&self) -> impl Iterator<Item = &Statement> {
        self.0.iter()
    }

    /// What is wrong with them for every target.
    pub fn wrong(&self) -> Vec<Finding> {
        self.iter().flat_map(Statement::values_wrong).collect()
    }
}

fn set(parameters: &mut Vec<Parameter>, one: Parameter) {
    let known = parameters.iter().map(|known| (known.name.as_str(), known.kind.as_deref()));
    match replaced(known, &one.name, one.kind.as_deref()) {
        // The type that was said stays said.
        Some(at) => parameters[at] = Parameter { kind: one.kind.or_else(|| parameters[at].kind.take()), ..one },
        None => parameters.push(one),
    }
}

/// Which of the `known` parameters, each with its name and type, another one takes the place of: without a type the last one of its name,
/// with a type the one of that type, or of none.
pub fn replaced<'p>(
    known: impl DoubleEndedIterator<Item = (&'p str, Option<&'p str>)> + ExactSizeIterator,
    name: &str,
    kind: Option<&str>,
) -> Option<usize> {
    let mut known = known.enumerate();
    let found = match kind {
        None => known.rfind(|(_, (other, _))| *other == name),
        Some(kind) => known.find(|(_, (other, own))| *other == name && own.is_none_or(|own| own == kind)),
    };
    found.map(|(at, _)| at)
}

impl FromIterator<Statement> for Statements {
    fn from_iter<I: IntoIterator<Item = Statement>>(statements: I) -> Self {
        let mut all = Self::default();
        statements.into_iter().for_each(|one| all.give(one));
        all
    }
}

/// How a target takes statements.
pub struct Native {
    /// What cannot be written, and what is likely to be a mistake.
    pub check: fn(&Statements) -> Vec<Finding>,
    /// The size of the image where statements say it, for an image of the scene's own size: `[width, height]`.
    pub size: fn(&Statements, [u32; 2]) -> [u32; 2],
}

/// Whether a text is a word of letters, digits and what else is `allowed`, and begins with a letter or `_`.
pub fn is_word(text: &str, allowed: &str) -> bool {
    let mut letters = text.chars();
    letters.next().is_some_and(|first| first == '_' || first.is_ascii_alphabetic())
        && letters.all(|letter| letter == '_' || letter.is_ascii_alphanumeric() || allowed.contains(letter))
}

/// The name among `known` that differs from `name` by the case of its letters only.
pub fn other_case<'k>(name: &str, known: &[&'k str]) -> Option<&'k str> {
    known.iter().find(|known| **known != name && known.eq_ignore_ascii_case(name)).copied()
}

/// That a statement is likely to be another one.
pub fn misspelled(statement: &Statement, meant: &str, target: &str) -> Finding {
    let message = format!("{target} spells the statement `{}` as `{meant}`", statement.name);
    Finding::warn("misspelled-statement", statement.origin.clone(), message)
        .note("it is added as it is, and replaces nothing")
        .help(format!("write `{meant}`"))
}

/// A side of the image that a statement says.
pub fn side(value: Option<&Value>, default: u32) -> u32 {
    value.map_or(Some(default), |value| value.integer().and_then(|side| u32::try_from(side).ok())).unwrap_or(default)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: Kinds = Kinds { bool: "bool", integer: "integer", float: "float", string: "string" };

    #[test]
    fn types_follow_from_values() {
        let kind = |value: Value| Parameter::new("x", value).kind(&KINDS).map(str::to_owned);
        assert_eq!(kind(Value::Bool(true)).as_deref(), Some("bool"));
        assert_eq!(kind(Value::Integer(1)).as_deref(), Some("integer"));
        assert_eq!(kind(Value::Float(1.0)).as_deref(), Some("float"));
        assert_eq!(kind(Value::String("a".to_owned())).as_deref(), Some("string"));
        let list = |items: &[Value]| kind(Value::List(items.to_vec()));
        assert_eq!(list(&[Value::Integer(1), Value::Integer(2)]).as_deref(), Some("integer"));
        assert_eq!(list(&[Value::Integer(1), Value::Float(0.5), Value::Integer(2)]).as_deref(), Some("float"));
        assert_eq!(list(&[Value::Integer(1), Value::Bool(true)]), None);
        assert_eq!(list(&[]), None);
        assert_eq!(Parameter::typed("x", "rgb", Value::Integer(1)).kind(&KINDS), Some("rgb"));
    }

    #[test]
    fn later_parameters_replace_earlier_ones_of_their_name() {
        let text = |text: &str| Value::String(text.to_owned());
        let mut all = Statements::default();
        all.give(Statement::new(
            "sampler",
            vec![
                Parameter::typed("type", "", text("independent")),
                Parameter::typed("sampleCount", "integer", Value::Integer(2)),
            ],
        ));
        all.give(Statement::new("rfilter", vec![Parameter::new("type", text("box"))]));
        all.give(Statement::new("sampler", vec![Parameter::new("sampleCount", Value::Integer(8))]));
        let sampler = all.find("sampler").expect("a sampler");
        assert_eq!(sampler.parameters[1], Parameter::typed("sampleCount", "integer", Value::Integer(8)));
        assert_eq!((sampler.parameters.len(), sampler.own_type()), (2, Some("independent")));
        assert_eq!(all.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["sampler", "rfilter"]);
        // Another type is another parameter.
        all.give(Statement::new("sampler", vec![Parameter::typed("sampleCount", "float", Value::Float(1.0))]));
        assert_eq!(all.find("sampler").map(|one| one.parameters.len()), Some(3));
        // Without a type it is the last one of its name.
        all.give(Statement::new("sampler", vec![Parameter::new("sampleCount", Value::Integer(9))]));
        let values = all.find("sampler").map(|one| one.parameters.iter().map(|one| one.value.clone()).collect());
        assert_eq!(values, Some(vec![text("independent"), Value::Integer(8), Value::Integer(9)]));
    }

    #[test]
    fn values_that_no_text_can_hold_are_refused() {
        let with =
            |value: Value| Statements::from_iter([Statement::new("a", vec![Parameter::new("b", value)])]).wrong();
        assert_eq!(with(Value::Float(f64::NAN)).len(), 1);
        assert_eq!(with(Value::List(vec![Value::List(Vec::new())])).len(), 1);
        assert_eq!(with(Value::List(vec![Value::Float(1.0), Value::Integer(2)])).len(), 0);
    }
}
