//! Which files of a crate import which, by the text of their code.
//!
//! Counted are the paths that begin with `crate`, `super`, `self` or the name of a module in the folder of the file. A name
//! that a file re-exports counts as imported from the file that defines it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::Result;

/// A file by its module path; that of `lib.rs` and `main.rs` is empty.
pub type File = Vec<String>;

/// How many re-exports of re-exports are followed.
const MAX_REEXPORTS: usize = 12;

/// A file of code.
#[derive(Default)]
struct Code {
    /// Paths as they stand in it.
    paths: BTreeSet<Vec<String>>,
    /// Names that it imports, and the paths of them; of `*` the name is empty.
    names: Vec<(String, Vec<String>)>,
}

/// What every file below `source` imports.
pub fn imports(source: &Path) -> Result<BTreeMap<File, BTreeSet<File>>> {
    let mut texts = BTreeMap::new();
    collect(source, &mut Vec::new(), &mut texts)?;
    Ok(between(&texts.into_iter().map(|(file, text)| (file, Code::of(&text))).collect()))
}

/// What every file imports of the others.
fn between(files: &BTreeMap<File, Code>) -> BTreeMap<File, BTreeSet<File>> {
    let of = |file: &File, code: &Code| {
        let paths = code.paths.iter().chain(code.names.iter().map(|(_, path)| path));
        let found = paths.filter_map(|path| Some(resolve(files, &absolute(files, file, path)?, 0)));
        found.filter(|other| other != file).collect()
    };
    files.iter().map(|(file, code)| (file.clone(), of(file, code))).collect()
}

/// The texts of all files but tests.
fn collect(folder: &Path, module: &mut File, texts: &mut BTreeMap<File, String>) -> Result {
    let failed = |path: &Path, why: std::io::Error| format!("{}: {why}", path.display());
    for entry in std::fs::read_dir(folder).map_err(|why| failed(folder, why))?.flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if path.is_dir() {
            if !["tests", "bin"].contains(&name.as_str()) {
                module.push(name);
                collect(&path, module, texts)?;
                module.pop();
            }
        } else if let Some(stem) = name.strip_suffix(".rs").filter(|stem| !stem.ends_with("tests")) {
            let text = std::fs::read_to_string(&path).map_err(|why| failed(&path, why))?;
            let is_root = module.is_empty() && ["lib", "main"].contains(&stem);
            let own = if is_root { None } else { Some(stem.to_owned()) };
            texts.entry(module.iter().cloned().chain(own).collect()).or_default().push_str(&text);
        }
    }
    Ok(())
}

/// A path from the root of the crate; `None` for those of other crates.
fn absolute(files: &BTreeMap<File, Code>, file: &File, path: &[String]) -> Option<Vec<String>> {
    let first = path.first()?.as_str();
    let mut base = file.clone();
    let rest = match first {
        "crate" => return Some(path[1..].to_vec()),
        "self" => &path[1..],
        "super" => {
            let count = path.iter().take_while(|name| *name == "super").count();
            base.truncate(base.len().saturating_sub(count));
            &path[count..]
        }
        _ => {
            base.push(first.to_owned());
            let is_child = files.contains_key(&base);
            base.pop();
            is_child.then_some(path)?
        }
    };
    base.extend(rest.iter().cloned());
    Some(base)
}

/// The file that defines what a path from the root names.
fn resolve(files: &BTreeMap<File, Code>, path: &[String], depth: usize) -> File {
    let mut file = File::new();
    for (k, name) in path.iter().enumerate() {
        file.push(name.clone());
        if files.contains_key(&file) {
            continue;
        }
        file.pop();
        let Some(code) = files.get(&file).filter(|_| depth < MAX_REEXPORTS) else { return file };
        let found = code.names.iter().find(|(imported, _)| imported == name);
        let target = found.and_then(|(_, target)| absolute(files, &file, target));
        return match target {
            Some(target) => resolve(files, &[&target, &path[k + 1..]].concat(), depth + 1),
            None => file,
        };
    }
    file
}

impl Code {
    fn of(text: &str) -> Self {
        let tokens = without_tests(&tokens(text));
        let mut code = Self::default();
        let mut k = 0;
        while k < tokens.len() {
            if tokens[k] == "use" {
                k += 1;
                code.tree(&tokens, &mut k, &[]);
            } else if is_name(&tokens[k]) && (k == 0 || tokens[k - 1] != "::") {
                let mut path = vec![tokens[k].clone()];
                while tokens.get(k + 1).is_some_and(|token| token == "::")
                    && tokens.get(k + 2).is_some_and(|t| is_name(t))
                {
                    path.push(tokens[k + 2].clone());
                    k += 2;
                }
                if path.len() > 1 {
                    code.paths.insert(path);
                }
            }
            k += 1;
        }
        code
    }

    /// Reads a tree of `use` up to what follows it.
    fn tree(&mut self, tokens: &[String], k: &mut usize, before: &[String]) {
        let mut path = before.to_vec();
        while let Some(token) = tokens.get(*k) {
            *k += 1;
            match token.as_str() {
                "::" => {}
                "{" => {
                    while tokens.get(*k).is_some_and(|token| token != "}") {
                        self.tree(tokens, k, &path);
                        *k += usize::from(tokens.get(*k).is_some_and(|token| token == ","));
                    }
                    *k += 1;
                    return;
                }
                "as" => {
                    self.names.push((tokens.get(*k).cloned().unwrap_or_default(), path));
                    *k += 1;
                    return;
                }
                "*" => {
                    self.names.push((String::new(), path));
                    return;
                }
                name if is_name(name) => {
                    if name != "self" || path.is_empty() {
                        path.push(name.to_owned());
                    }
                    // A path ends where neither `::` nor `as` follows.
                    if !tokens.get(*k).is_some_and(|next| next == "::" || next == "as") {
                        self.names.push((path.last().cloned().unwrap_or_default(), path));
                        return;
                    }
                }
                _ => {
                    *k -= 1;
                    return;
                }
            }
        }
    }
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Names, `::` and single characters of code, without spaces, comments, texts and characters.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(raw) = rest.strip_prefix("r#\"") {
            raw.find("\"#").map_or(rest.len(), |end| end + 5)
        } else if first == '"' {
            end_of_text(rest, '"')
        } else if first == '\'' {
            end_of_character(rest)
        } else if rest.starts_with("::") {
            tokens.push("::".into());
            2
        } else if is_name(rest) {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            tokens.push(rest[..end].to_owned());
            end
        } else {
            if !first.is_whitespace() {
                tokens.push(first.to_string());
            }
            first.len_utf8()
        };
        rest = &rest[skipped..];
    }
    tokens
}

/// Behind the closing mark of a text that begins here.
fn end_of_text(text: &str, mark: char) -> usize {
    let mut is_escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            c if c == mark => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// Behind a character, or behind the mark of a lifetime.
fn end_of_character(text: &str) -> usize {
    let mut inside = text.char_indices().skip(1);
    match (inside.next(), inside.next()) {
        (Some((_, '\\')), _) => end_of_text(text, '\''),
        (Some(_), Some((at, '\''))) => at + 1,
        _ => 1,
    }
}

/// Without the items behind `#[cfg(test)]`.
fn without_tests(tokens: &[String]) -> Vec<String> {
    let mark = ["#", "[", "cfg", "(", "test", ")", "]"];
    let mut left = Vec::new();
    let mut k = 0;
    while k < tokens.len() {
        if tokens[k..].len() >= mark.len()
            && tokens[k..k + mark.len()].iter().zip(mark).all(|(token, mark)| token == mark)
        {
            k = end_of_item(tokens, k + mark.len());
        } else {
            left.push(tokens[k].clone());
            k += 1;
        }
    }
    left
}

/// Behind the `;` or the braces of an item.
fn end_of_item(tokens: &[String], from: usize) -> usize {
    let (mut depth, is_use) = (0, tokens.get(from).is_some_and(|token| token == "use"));
    for (k, token) in tokens.iter().enumerate().skip(from) {
        match token.as_str() {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => {
                depth -= 1;
                if depth == 0 && token == "}" && !is_use {
                    return k + 1;
                }
            }
            ";" if depth == 0 => return k + 1,
            _ => {}
        }
    }
    tokens.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str) -> File {
        path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect()
    }

    fn imports_of(texts: &[(&str, &str)], of: &str) -> Vec<String> {
        let files: BTreeMap<File, Code> = texts.iter().map(|(path, text)| (file(path), Code::of(text))).collect();
        between(&files)[&file(of)].iter().map(|file| file.join("::")).collect()
    }

    #[test]
    fn imports_are_taken_from_code_alone() {
        let text = "use crate::{Error, a::{self, x}, b as c};\n// crate::d\nfn f() { crate::d::g(\"crate::e\", '{') }\n\
                    #[cfg(test)]\nmod tests { use crate::e; fn f() {} }\nuse super::f::y;";
        let others = ["a", "b", "d", "e", "f"].map(|name| (name, ""));
        let texts = [&[("", "mod error;"), ("here", text)], others.as_slice()].concat();
        assert_eq!(imports_of(&texts, "here"), ["", "a", "b", "d", "f"]);
    }

    #[test]
    fn names_are_those_of_the_file_that_defines_them() {
        let texts = [
            ("", "mod a; pub use a::inner::Thing;"),
            ("a", "mod inner; pub use inner::Thing;"),
            ("a::inner", "pub struct Thing;"),
            ("b", "use crate::Thing; fn f(_: super::a::Thing) {}"),
        ];
        assert_eq!(imports_of(&texts, "b"), ["a::inner"]);
        assert_eq!(imports_of(&texts, "a"), ["a::inner"]);
    }
}
