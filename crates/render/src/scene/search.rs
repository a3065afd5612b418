//! Where the files that a scene names are looked for.

use std::path::{Path, PathBuf};

use super::error::quoted;

/// Folders in the order in which they are tried: the folder of the scene file, then its `<path>` elements.
#[derive(Debug, Clone)]
pub(super) struct Search(Vec<PathBuf>);

impl Search {
    /// Starts in the folder of `file`, then in the folders of the file that includes it.
    pub(super) fn beside(file: &Path, outer: Option<&Self>) -> Self {
        let mut folders = vec![file.parent().unwrap_or(Path::new("")).to_owned()];
        if let Some(outer) = outer {
            folders.extend(outer.0.iter().cloned());
        }
        Self(folders)
    }

    /// Adds a folder, itself looked for in the folders known so far.
    pub(super) fn add(&mut self, folder: &str) -> Result<(), String> {
        let found = self
            .candidates(folder)
            .find(|candidate| candidate.is_dir())
            .ok_or_else(|| format!("no folder {}, looked in {}", quoted(folder), self.list()))?;
        self.0.push(found);
        Ok(())
    }

    /// The first of the folders in which the file exists, joined with its name.
    pub(super) fn find(&self, name: &str) -> Result<PathBuf, String> {
        if name.is_empty() {
            return Err("the file name is empty, expected the name of a file".to_owned());
        }
        if name.contains('\0') {
            return Err("the file name contains a zero byte".to_owned());
        }
        let mut existing = self.candidates(name).filter(|candidate| candidate.exists());
        let Some(first) = existing.next() else {
            return Err(format!(
                "no file {}, looked in {}",
                quoted(name),
                self.list()
            ));
        };
        if first.is_dir() {
            return Err(format!("{} is a directory, expected a file", quoted(name)));
        }
        Ok(first)
    }

    fn candidates(&self, name: &str) -> impl Iterator<Item = PathBuf> {
        self.0.iter().map(move |folder| folder.join(name))
    }

    fn list(&self) -> String {
        let name = |folder: &PathBuf| match folder.to_string_lossy() {
            empty if empty.is_empty() => "'.'".to_owned(),
            other => format!("'{other}'"),
        };
        let mut names: Vec<_> = self.0.iter().map(name).collect();
        names.dedup();
        names.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn the_folder_of_the_file_comes_first_then_the_paths() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        fs::create_dir(root.join("more")).unwrap();
        fs::write(root.join("more/a.obj"), "").unwrap();
        let mut search = Search::beside(&root.join("scene.xml"), None);
        assert!(
            search
                .find("a.obj")
                .unwrap_err()
                .starts_with("no file 'a.obj', looked in '")
        );
        search.add("more").unwrap();
        assert_eq!(search.find("a.obj").unwrap(), root.join("more/a.obj"));
        fs::write(root.join("a.obj"), "").unwrap();
        assert_eq!(search.find("a.obj").unwrap(), root.join("a.obj"));
        assert_eq!(
            search.find("more").unwrap_err(),
            "'more' is a directory, expected a file"
        );
    }

    #[test]
    fn names_that_are_no_files_are_refused() {
        let mut search = Search::beside(Path::new("scene.xml"), None);
        assert_eq!(
            search.add("nowhere").unwrap_err(),
            "no folder 'nowhere', looked in '.'"
        );
        assert!(search.find("").unwrap_err().contains("empty"));
        assert!(search.find("a\0b").unwrap_err().contains("zero byte"));
        assert!(search.find(&"x/".repeat(5000)).is_err());
    }
}
