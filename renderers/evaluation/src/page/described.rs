//! What an evaluation file says of its test cases, for people.

use super::model::Case;

/// The cases of a file, in its order; none where it cannot be read.
pub(super) fn cases(text: &str) -> Vec<Case> {
    let Ok(file) = text.parse::<toml::Table>() else { return Vec::new() };
    let Some(all) = file.get("case").and_then(toml::Value::as_array) else { return Vec::new() };
    all.iter().filter_map(toml::Value::as_table).map(case).collect()
}

fn case(table: &toml::Table) -> Case {
    let word = |name: &str| table.get(name).and_then(toml::Value::as_str).unwrap_or_default().to_owned();
    let rest: toml::Table = table
        .iter()
        .filter(|(name, _)| !matches!(name.as_str(), "name" | "description"))
        .map(|(name, value)| (name.clone(), value.clone()))
        .collect();
    let settings = toml::to_string(&rest).unwrap_or_default().trim_end().to_owned();
    Case { name: word("name"), description: word("description"), settings }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_are_described_as_their_file_does() {
        let text = "[[case]]\nname = \"a\"\ndescription = \"b\"\nrenderer = \"x\"\nsettings = { samples = 4 }\n[[case]]\nname = \"c\"\n";
        let found = cases(text);
        assert_eq!((found.len(), found[0].description.as_str(), found[1].settings.as_str()), (2, "b", ""));
        assert!(
            found[0].settings.contains("renderer = \"x\"") && found[0].settings.contains("samples = 4"),
            "{found:?}"
        );
        assert!(cases("[[case").is_empty() && cases("case = 1").is_empty());
    }
}
