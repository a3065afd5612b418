//! `$name` in attributes: values from `-D name=value` and `<default>`.

use super::error::{nearest, suggestion};

/// Most bytes that substitution may make in one scene, so that defaults that double each other cannot fill the memory.
const MAX_MADE: usize = 1 << 26;

struct Define {
    name: String,
    value: String,
    used: bool,
}

/// The values that `$name` may take at this point of the file.
pub(super) struct Defines {
    list: Vec<Define>,
    made: usize,
}

impl Defines {
    /// Starts with the values of the command line, which win over every `<default>`.
    pub(super) fn new(given: &[(String, String)]) -> Result<Self, String> {
        let mut defines = Self {
            list: Vec::new(),
            made: 0,
        };
        for (name, value) in given {
            if name.is_empty() || name.contains(['$', '\\']) {
                return Err(format!(
                    "'-D {name}={value}' has no usable name, expected -D NAME=VALUE"
                ));
            }
            if defines.names().any(|known| known == name) {
                return Err(format!("'-D {name}' is given twice, expected one value"));
            }
            defines.add(name, value, false);
        }
        Ok(defines)
    }

    /// A value for `$name` unless it already has one.
    pub(super) fn set_default(&mut self, name: &str, value: &str) {
        if !self.names().any(|known| known == name) {
            self.add(name, value, true);
        }
    }

    fn add(&mut self, name: &str, value: &str, used: bool) {
        self.list.push(Define {
            name: name.to_owned(),
            value: value.to_owned(),
            used,
        });
    }

    fn names(&self) -> impl Iterator<Item = &str> {
        self.list.iter().map(|define| define.name.as_str())
    }

    /// The text with every `$name` replaced; `\$` stands for a dollar sign.
    ///
    /// As in Mitsuba the longest known name that fits wins: with `a` and `ab` known, `$abc` is the value of `ab`,
    /// then `c`.
    pub(super) fn substitute(&mut self, text: &str) -> Result<String, String> {
        let mut out = String::new();
        let mut rest = text;
        while let Some(at) = rest.find('$') {
            let (before, after) = (&rest[..at], &rest[at + 1..]);
            if let Some(escaped) = before.strip_suffix('\\') {
                out.push_str(escaped);
                out.push('$');
                rest = after;
                continue;
            }
            out.push_str(before);
            let define = self
                .list
                .iter_mut()
                .filter(|define| after.starts_with(&define.name))
                .max_by_key(|define| define.name.len());
            let Some(define) = define else {
                return Err(self.undefined(after));
            };
            define.used = true;
            out.push_str(&define.value);
            self.made += define.value.len();
            if self.made > MAX_MADE {
                return Err("the values put in for '$' names exceed 64 MiB, \
                            look for defaults that contain each other"
                    .to_owned());
            }
            rest = &after[define.name.len()..];
        }
        out.push_str(rest);
        Ok(out)
    }

    fn undefined(&self, after: &str) -> String {
        let end = after
            .find(|c: char| !c.is_alphanumeric() && c != '_')
            .unwrap_or(after.len());
        let name = &after[..end];
        let remedy = match nearest(name, self.names()) {
            Some(near) => format!("did you mean '${near}'?"),
            None if name.is_empty() => "write '\\$' for a dollar sign".to_owned(),
            None => format!("expected <default name=\"{name}\" …/> before it or -D {name}=VALUE"),
        };
        format!("'${name}' has no value, {remedy}")
    }

    /// What to say about values of the command line that no `$name` has used.
    pub(super) fn unused(&self) -> Option<String> {
        let unused = self.list.iter().find(|define| !define.used)?;
        let others: Vec<_> = self.names().filter(|name| *name != unused.name).collect();
        let name = &unused.name;
        Some(format!(
            "'-D {name}' has no effect, the scene has no '${name}'{}",
            suggestion(name, &others)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn defines(given: &[(&str, &str)]) -> Defines {
        let given: Vec<_> = given
            .iter()
            .map(|&(name, value)| (name.to_owned(), value.to_owned()))
            .collect();
        Defines::new(&given).unwrap()
    }

    #[test]
    fn the_command_line_wins_over_defaults_and_the_first_default_over_later_ones() {
        let mut defines = defines(&[("spp", "16")]);
        defines.set_default("spp", "64");
        defines.set_default("width", "96");
        defines.set_default("width", "1");
        assert_eq!(defines.substitute("$spp x $width").unwrap(), "16 x 96");
        assert_eq!(defines.unused(), None);
    }

    #[test]
    fn the_longest_name_wins_and_a_backslash_keeps_the_dollar() {
        let mut defines = defines(&[("a", "1"), ("ab", "2")]);
        assert_eq!(defines.substitute("$abc$a-\\$a").unwrap(), "2c1-$a");
    }

    #[test]
    fn unknown_names_are_refused_with_a_remedy() {
        let mut defines = defines(&[("spp", "1")]);
        assert_eq!(
            defines.substitute("$sp").unwrap_err(),
            "'$sp' has no value, did you mean '$spp'?"
        );
        assert_eq!(
            defines.substitute("1$").unwrap_err(),
            "'$' has no value, write '\\$' for a dollar sign"
        );
        assert_eq!(
            defines.substitute("$width,").unwrap_err(),
            "'$width' has no value, expected <default name=\"width\" …/> before it or -D width=VALUE"
        );
    }

    #[test]
    fn a_value_that_nothing_uses_is_reported() {
        let mut defines = defines(&[("sp", "1")]);
        defines.set_default("spp", "4");
        defines.set_default("width", "4");
        assert_eq!(
            defines.unused().unwrap(),
            "'-D sp' has no effect, the scene has no '$sp', did you mean 'spp'?"
        );
    }

    #[test]
    fn defaults_that_double_each_other_stop_at_64_mib() {
        let mut defines = defines(&[]);
        defines.set_default("a0", "xxxxxxxx");
        let outcome = (0..40).try_for_each(|i| {
            let value = defines.substitute(&format!("$a{i}$a{i}"))?;
            defines.set_default(&format!("a{}", i + 1), &value);
            Ok(())
        });
        let message: String = outcome.unwrap_err();
        assert!(message.contains("exceed 64 MiB"), "{message}");
    }
}
