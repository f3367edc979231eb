//! Classes of light paths in Heckbert's notation, and their full form after Veach's thesis (1997, section 8.3).
//!
//! A class is a regular expression over the vertices of paths from the light to the eye. Letters: `L` light, `E` eye, `D`
//! diffuse, `G` glossy, `S` specular; `( ) | * +` as usual; blanks are for the reader. The short form says what surfaces a
//! path meets: `LDDE`. The full form also says what light and eye are, by two letters each for place and direction: an area
//! light is `LDD` (it has an extent, and emits into many directions), a point light `LSD`, a pinhole camera `DSE`; its first
//! and last words are these: `LDD S+ D DSE`. Either order of the two letters is read, since authors differ. A class without
//! `L` or `E` is a part of paths: `SDS`.
//!
//! Local sampling (path tracing, light tracing, bidirectional path tracing) finds a path only where two neighboring letters
//! of its full form are `D`: they can be connected, or met by chance. `G` counts as `D`: a glossy lobe has an extent.

/// A class of light paths.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightPaths {
    form: Form,
    full: bool,
}

/// Why a text is no class of light paths.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightPathError {
    /// The byte at which the text stops being one.
    pub at: usize,
    /// What is wrong there.
    pub message: &'static str,
}

/// What the light of a path is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightExtent {
    /// It has an extent: `LDD`.
    Area,
    /// It is a point: `LSD`.
    Point,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Form {
    /// A letter and its place.
    Letter(char, usize),
    Sequence(Vec<Form>),
    Either(Vec<Form>),
    /// Any number of times; at least once where the flag says so.
    Repeated(Box<Form>, bool),
}

/// Lights in the full form.
const LIGHTS: &[&str] = &["LDD", "LDS", "LSD", "LSS"];

/// Eyes in the full form.
const EYES: &[&str] = &["SDE", "DDE", "SSE", "DSE"];

/// How deep brackets may lie in each other.
const DEPTH: usize = 32;

impl LightPaths {
    /// The class that `text` writes.
    ///
    /// # Errors
    /// What is wrong, and where.
    pub fn parse(text: &str) -> Result<Self, LightPathError> {
        let mut parser = Parser { text, at: 0, depth: 0 };
        let form = parser.either()?;
        if parser.peek().is_some() {
            return Err(parser.error("this bracket closes nothing"));
        }
        form.check_ends(true, true)?;
        let words: Vec<&str> = text.split_whitespace().collect();
        let spelled = |word: Option<&&str>, known: &[&str]| word.is_some_and(|word| known.contains(word));
        let full = words.len() > 1 && spelled(words.first(), LIGHTS) && spelled(words.last(), EYES);
        Ok(Self { form, full })
    }

    /// A text without what does not count: two texts of one form are equal in it.
    pub fn canonical(text: &str) -> String {
        text.chars().filter(|letter| !letter.is_whitespace()).collect()
    }

    /// Whether the class is one of whole paths, from the light to the eye, and not of parts.
    pub fn is_whole(&self) -> bool {
        self.form.begins() && self.form.ends()
    }

    /// The full form of the class that `text` writes, for lights of `kind` and a pinhole camera.
    pub fn full_form(&self, text: &str, kind: LightExtent) -> String {
        if self.full {
            return text.trim().to_owned();
        }
        let light = match kind {
            LightExtent::Area => "LDD ",
            LightExtent::Point => "LSD ",
        };
        let spelled = text.replace('L', light).replace('E', " DSE");
        spelled.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// The paths of the class with at most `longest` vertices between light and eye, as their letters `D`, `G`, `S`, the shorter ones
    /// first. Of a class of parts, the paths that hold one.
    pub fn paths(&self, longest: usize) -> Vec<String> {
        let mut found = Vec::new();
        let mut words = vec![String::new()];
        for length in 0..=longest {
            found.extend(words.iter().filter(|word| self.holds(word)).cloned());
            if length < longest {
                words = words.iter().flat_map(|word| ['D', 'G', 'S'].map(|letter| format!("{word}{letter}"))).collect();
            }
        }
        found
    }

    /// Whether the path whose vertices between light and eye are `word` is of the class, or holds a part that is.
    pub fn holds(&self, word: &str) -> bool {
        let matches = |light: &str, eye: &str| {
            let letters: Vec<char> = format!("{light}{word}{eye}").chars().collect();
            let starts = if self.form.begins() { 1 } else { (1 << letters.len()) - 1 };
            let ends = self.form.ends_of(&letters, starts);
            if self.form.ends() { ends >> letters.len() & 1 == 1 } else { ends != 0 }
        };
        if !self.full {
            return matches("L", "E");
        }
        LIGHTS.iter().any(|light| EYES.iter().any(|eye| matches(light, eye)))
    }

    /// Whether local sampling finds every path of the class, where lights are of `kind` and the camera is a pinhole.
    pub fn is_found_by_local_sampling(&self, kind: LightExtent) -> bool {
        let mut machine = Machine { full: self.full, kind };
        let after = machine.walk(&self.form, State::START);
        !after.has(State::START.0 | State::AFTER_D.0)
    }
}

impl Form {
    /// Whether every path begins at a light.
    fn begins(&self) -> bool {
        match self {
            Self::Letter(letter, _) => *letter == 'L',
            Self::Sequence(parts) => parts.first().is_some_and(Self::begins),
            Self::Either(ways) => ways.iter().all(Self::begins),
            Self::Repeated(..) => false,
        }
    }

    /// Whether every path ends at an eye.
    fn ends(&self) -> bool {
        match self {
            Self::Letter(letter, _) => *letter == 'E',
            Self::Sequence(parts) => parts.last().is_some_and(Self::ends),
            Self::Either(ways) => ways.iter().all(Self::ends),
            Self::Repeated(..) => false,
        }
    }

    /// Where in `letters` what begins at one of `starts` may end; places are bits, the last one behind the last letter.
    fn ends_of(&self, letters: &[char], starts: u64) -> u64 {
        match self {
            Self::Letter(letter, _) => {
                let at = |place: &usize| starts >> *place & 1 == 1 && letters[*place] == *letter;
                (0..letters.len()).filter(at).fold(0, |ends, place| ends | 1 << (place + 1))
            }
            Self::Sequence(parts) => parts.iter().fold(starts, |places, part| part.ends_of(letters, places)),
            Self::Either(ways) => ways.iter().fold(0, |ends, way| ends | way.ends_of(letters, starts)),
            Self::Repeated(part, once) => {
                let mut reached = if *once { part.ends_of(letters, starts) } else { starts };
                loop {
                    let more = reached | part.ends_of(letters, reached);
                    if more == reached {
                        return reached;
                    }
                    reached = more;
                }
            }
        }
    }

    /// `L` stands first and `E` last, if at all.
    fn check_ends(&self, first: bool, last: bool) -> Result<(), LightPathError> {
        match self {
            Self::Letter('L', at) if !first => Err(LightPathError { at: *at, message: "a path begins at the light" }),
            Self::Letter('E', at) if !last => Err(LightPathError { at: *at, message: "a path ends at the eye" }),
            Self::Letter(..) => Ok(()),
            Self::Sequence(parts) => {
                let end = parts.len().saturating_sub(1);
                parts.iter().enumerate().try_for_each(|(at, part)| part.check_ends(first && at == 0, last && at == end))
            }
            Self::Either(ways) => ways.iter().try_for_each(|way| way.check_ends(first, last)),
            Self::Repeated(part, _) => part.check_ends(false, false),
        }
    }
}

/// Which of the three states of the search for `DD` some path of the class is in: nothing yet, just behind a `D`, found.
#[derive(Clone, Copy, PartialEq, Eq)]
struct State(u8);

impl State {
    const NONE: Self = Self(0);
    const START: Self = Self(1);
    const AFTER_D: Self = Self(2);
    const FOUND: Self = Self(4);

    fn has(self, bits: u8) -> bool {
        self.0 & bits != 0
    }

    fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    fn letter(self, letter: char) -> Self {
        let scatters = matches!(letter, 'D' | 'G');
        let mut next = if self.has(Self::FOUND.0) { Self::FOUND } else { Self::NONE };
        if self.has(Self::START.0) {
            next = next.or(if scatters { Self::AFTER_D } else { Self::START });
        }
        if self.has(Self::AFTER_D.0) {
            next = next.or(if scatters { Self::FOUND } else { Self::START });
        }
        next
    }
}

/// Follows all paths of a class at once.
struct Machine {
    full: bool,
    kind: LightExtent,
}

impl Machine {
    fn walk(&mut self, form: &Form, from: State) -> State {
        match form {
            Form::Letter('L', _) if !self.full => {
                let spelled = match self.kind {
                    LightExtent::Area => "LDD",
                    LightExtent::Point => "LSD",
                };
                spelled.chars().fold(from, State::letter)
            }
            Form::Letter('E', _) if !self.full => "DSE".chars().fold(from, State::letter),
            Form::Letter(letter, _) => from.letter(*letter),
            Form::Sequence(parts) => parts.iter().fold(from, |state, part| self.walk(part, state)),
            Form::Either(ways) => ways.iter().fold(State::NONE, |state, way| state.or(self.walk(way, from))),
            Form::Repeated(part, once) => {
                // Three states: three rounds reach everything that can be reached.
                let mut reached = if *once { self.walk(part, from) } else { from };
                for _ in 0..3 {
                    reached = reached.or(self.walk(part, reached));
                }
                reached
            }
        }
    }
}

struct Parser<'t> {
    text: &'t str,
    at: usize,
    depth: usize,
}

impl Parser<'_> {
    fn peek(&mut self) -> Option<char> {
        let rest = self.text[self.at..].trim_start();
        self.at = self.text.len() - rest.len();
        rest.chars().next()
    }

    fn error(&mut self, message: &'static str) -> LightPathError {
        self.peek();
        LightPathError { at: self.at, message }
    }

    fn either(&mut self) -> Result<Form, LightPathError> {
        let mut ways = vec![self.sequence()?];
        while self.peek() == Some('|') {
            self.at += 1;
            ways.push(self.sequence()?);
        }
        Ok(if ways.len() == 1 { ways.remove(0) } else { Form::Either(ways) })
    }

    fn sequence(&mut self) -> Result<Form, LightPathError> {
        let mut parts = Vec::new();
        loop {
            let part = match self.peek() {
                None | Some('|' | ')') => break,
                Some(letter @ ('L' | 'E' | 'D' | 'G' | 'S')) => {
                    self.at += 1;
                    Form::Letter(letter, self.at - 1)
                }
                Some('(') => self.brackets()?,
                Some('*' | '+') => return Err(self.error("there is nothing to repeat before this")),
                Some('l' | 'e' | 'd' | 'g' | 's') => return Err(self.error("letters are capitals")),
                Some(_) => return Err(self.error("this is no letter of a path")),
            };
            parts.push(self.repeated(part));
        }
        if parts.is_empty() {
            return Err(self.error("a path is missing here"));
        }
        Ok(if parts.len() == 1 { parts.remove(0) } else { Form::Sequence(parts) })
    }

    fn brackets(&mut self) -> Result<Form, LightPathError> {
        if self.depth == DEPTH {
            return Err(self.error("brackets lie too deep in each other"));
        }
        let opening = self.at;
        self.at += 1;
        self.depth += 1;
        let inner = self.either()?;
        self.depth -= 1;
        if self.peek() != Some(')') {
            return Err(LightPathError { at: opening, message: "this bracket is not closed" });
        }
        self.at += 1;
        Ok(inner)
    }

    fn repeated(&mut self, part: Form) -> Form {
        let mut often: Option<bool> = None;
        while let Some(sign @ ('*' | '+')) = self.peek() {
            self.at += 1;
            often = Some(often.unwrap_or(true) && sign == '+');
        }
        match often {
            Some(once) => Form::Repeated(Box::new(part), once),
            None => part,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn found(text: &str, kind: LightExtent) -> bool {
        LightPaths::parse(text).expect("a class").is_found_by_local_sampling(kind)
    }

    #[test]
    fn mistakes_have_their_place() {
        let wrong = |text: &str| LightPaths::parse(text).map_err(|error| (error.at, error.message));
        for good in ["LDE", "LS+DE", "L(S|D)*E", "LDD S+ D SDE", "SDS", "LD(S|G)+DE", "(LDE|LSE)", "LDDSDE", "L D E"] {
            assert!(LightPaths::parse(good).is_ok(), "{good}");
        }
        assert_eq!(wrong(""), Err((0, "a path is missing here")));
        assert_eq!(wrong("LXE"), Err((1, "this is no letter of a path")));
        assert_eq!(wrong("lde"), Err((0, "letters are capitals")));
        assert_eq!(wrong("L(DE"), Err((1, "this bracket is not closed")));
        assert_eq!(wrong("LD)E"), Err((2, "this bracket closes nothing")));
        assert_eq!(wrong("L*DE"), Err((0, "a path begins at the light")));
        assert_eq!(wrong("LDLE"), Err((2, "a path begins at the light")));
        assert_eq!(wrong("ELD"), Err((0, "a path ends at the eye")));
        assert_eq!(wrong("L|+E"), Err((2, "there is nothing to repeat before this")));
        assert_eq!(wrong("L()E"), Err((2, "a path is missing here")));
        assert_eq!(wrong(&"(".repeat(100)), Err((DEPTH, "brackets lie too deep in each other")));
    }

    #[test]
    fn paths_that_nothing_connects() {
        // Veach 1997, section 8.3.4: with a point light and a pinhole, `LSDSE` cannot be sampled locally.
        assert!(!found("LSDSE", LightExtent::Point));
        assert!(found("LSDSE", LightExtent::Area));
        assert!(
            found("LDE", LightExtent::Point) && found("LDDE", LightExtent::Point) && found("LSDDE", LightExtent::Point)
        );
        assert!(!found("LS*DS*E", LightExtent::Point), "with an `S` on both sides");
        assert!(!found("LSE", LightExtent::Point));
        assert!(found("LDD S+ D DSE", LightExtent::Point), "the full form says what the light is");
        assert!(!found("LSD S+ D S DSE", LightExtent::Area));
        assert!(found("L(S|D)DE", LightExtent::Point) && !found("L(SDS|D)E", LightExtent::Point), "every path counts");
        assert!(found("LGGE", LightExtent::Point));
        let whole = |text: &str| LightPaths::parse(text).is_ok_and(|class| class.is_whole());
        assert!(whole("LDE") && whole("(LD|LS)(DE|SE)") && !whole("SDS") && !whole("LD") && !whole("(LD|S)E"));
    }

    #[test]
    fn classes_have_their_paths() {
        let paths = |text: &str, longest: usize| LightPaths::parse(text).expect("a class").paths(longest).join(" ");
        assert_eq!(paths("LDE", 3), "D");
        assert_eq!(paths("LE", 3), "");
        assert_eq!(LightPaths::parse("LE").expect("a class").paths(3), [""]);
        assert_eq!(paths("LS+DE", 3), "SD SSD");
        assert_eq!(paths("L(D|G)*E", 2), " D G DD DG GD GG");
        assert_eq!(paths("L(DS)+E", 4), "DS DSDS");
        assert_eq!(paths("LDD S D DSE", 3), "SD");
        assert_eq!(paths("DS", 3), "DS DDS DSD DSG DSS GDS SDS");
        assert_eq!(paths("LD", 2), "D DD DG DS", "a part that begins at the light");
        assert_eq!(LightPaths::parse("L(S|D|G)*E").expect("a class").paths(5).len(), 364);
    }

    #[test]
    fn classes_have_a_full_form_and_hold_paths() {
        let holds = |class: &str, word: &str| LightPaths::parse(class).expect("a class").holds(word);
        assert!(holds("LDE", "D") && !holds("LDE", "DD") && !holds("LDE", "G"));
        assert!(holds("LDD S+ D DSE", "SD") && !holds("LDD S+ D DSE", "D") && holds("SDS", "DSDS"));
        let full = |class: &str, kind| LightPaths::parse(class).expect("a class").full_form(class, kind);
        assert_eq!(full("LS+DE", LightExtent::Area), "LDD S+D DSE");
        assert_eq!(full("(LD|LS)DE", LightExtent::Point), "(LSD D|LSD S)D DSE");
        assert_eq!(full("LDD S D DSE", LightExtent::Point), "LDD S D DSE");
    }

    proptest! {
        #[test]
        fn any_text_is_read(text in "[LEDGS()|*+ x]{0,40}") {
            match LightPaths::parse(&text) {
                Ok(class) => prop_assert!(class.paths(2).iter().all(|path| path.len() <= 2)),
                Err(error) => prop_assert!(error.at <= text.len() && text.is_char_boundary(error.at)),
            }
        }
    }
}
