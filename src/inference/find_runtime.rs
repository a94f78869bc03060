//! Finds ONNX Runtime's library.
//!
//! A flag or an environment variable that names it comes first. Then follow Python's `onnxruntime`
//! package (without importing it), whose wheels hold the library from 1.19 on, and the system's
//! folders.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::library::Library;
use crate::error::{ChoiceError, Result};

/// Environment variables that name the library: ours, and the one of the crate `ort`.
const NAMED_BY: [&str; 2] = ["EDGEGAIT_ORT_LIB", "ORT_DYLIB_PATH"];
/// Environment variables that name a Python environment.
const PREFIXES: [&str; 2] = ["VIRTUAL_ENV", "CONDA_PREFIX"];
/// A Python program that prints where the package is. It leaves out the current folder, whose files
/// are not trusted.
const ASK: &str = "import sys\n\
    sys.path[:] = [path for path in sys.path if path]\n\
    import importlib.util\n\
    found = importlib.util.find_spec('onnxruntime')\n\
    print(found.submodule_search_locations[0] if found and found.origin else '')";
/// How long that program may take. Our choice: it takes 0.05 s, but a cold SD card is slow.
const PATIENCE: Duration = Duration::from_secs(10);

/// Finds the ONNX Runtime library: the one that `named` (a flag), `EDGEGAIT_ORT_LIB` or
/// `ORT_DYLIB_PATH` names, unchecked; else the first usable one beside the Python package of
/// `VIRTUAL_ENV`, `CONDA_PREFIX` or `python3`, or in a library folder of the system.
///
/// # Errors
/// If there is none; the error lists all places that were searched.
pub fn find_library(named: Option<&Path>) -> Result<PathBuf> {
    let search = Search {
        variable: &|name| std::env::var_os(name),
        python: if cfg!(windows) { "python" } else { "python3" }.into(),
        patience: PATIENCE,
        system: system_folders(),
    };
    search.find(named)
}

/// The places to search.
struct Search<'a> {
    variable: &'a dyn Fn(&str) -> Option<OsString>,
    python: PathBuf,
    patience: Duration,
    system: Vec<PathBuf>,
}

impl Search<'_> {
    fn find(&self, named: Option<&Path>) -> Result<PathBuf> {
        if let Some(path) = named {
            return Ok(path.to_path_buf());
        }
        if let Some(path) = NAMED_BY.iter().find_map(|name| self.path_in(name)) {
            return Ok(path);
        }
        let mut looked = vec!["a file by name: none given".to_owned()];
        looked.extend(NAMED_BY.iter().map(|name| format!("{name}: not set")));
        for prefix in PREFIXES {
            let folders = self.path_in(prefix).map(|prefix| wheels_of(&prefix));
            let Some(folders) = folders else {
                looked.push(format!("{prefix}: not set"));
                continue;
            };
            for folder in &folders {
                if let Some(path) = first_usable(folder, &mut looked) {
                    return Ok(path);
                }
            }
            if folders.is_empty() {
                looked.push(format!("{prefix}: no onnxruntime in it"));
            }
        }
        match self.ask_python() {
            Ok(package) => {
                if let Some(path) = first_usable(&package.join("capi"), &mut looked) {
                    return Ok(path);
                }
            }
            Err(problem) => looked.push(format!("{}: {problem}", self.python.display())),
        }
        for folder in &self.system {
            if let Some(path) = first_usable(folder, &mut looked) {
                return Ok(path);
            }
        }
        Err(ChoiceError::NoLibrary { looked }.into())
    }

    fn path_in(&self, variable: &str) -> Option<PathBuf> {
        let value = (self.variable)(variable).filter(|value| !value.is_empty());
        value.map(PathBuf::from)
    }

    /// Asks Python for the folder of its package.
    fn ask_python(&self) -> std::result::Result<PathBuf, String> {
        // A file, not a pipe: a process that Python leaves running would keep a pipe open.
        let answer = tempfile::NamedTempFile::new().map_err(|error| error.to_string())?;
        let out = answer.reopen().map_err(|error| error.to_string())?;
        let mut child = Command::new(&self.python)
            .args(["-c", ASK])
            .stdin(Stdio::null())
            .stdout(out)
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("cannot be run: {error}"))?;
        let asked = Instant::now();
        let status = loop {
            match child.try_wait() {
                Ok(Some(status)) => break status,
                Ok(None) if asked.elapsed() < self.patience => {
                    std::thread::sleep(Duration::from_millis(10));
                }
                _ => {
                    // Ignored: it may have ended by now.
                    let _ = child.kill();
                    let _ = child.wait();
                    return Err(format!("no answer in {} s", self.patience.as_secs_f32()));
                }
            }
        };
        let text = std::fs::read_to_string(answer.path()).map_err(|error| error.to_string())?;
        match text.trim() {
            "" => Err(format!("has no onnxruntime ({status})")),
            package => Ok(PathBuf::from(package)),
        }
    }
}

/// Returns the folders `onnxruntime/capi` of each Python in the environment with this prefix.
fn wheels_of(prefix: &Path) -> Vec<PathBuf> {
    let in_prefix = |folder: PathBuf| folder.join("site-packages/onnxruntime/capi");
    let mut folders = vec![in_prefix(prefix.join("Lib"))];
    let pythons = entries(&prefix.join("lib"));
    folders.extend(pythons.into_iter().map(in_prefix));
    folders.retain(|folder| folder.is_dir());
    folders
}

/// Returns the newest usable library in a folder. Otherwise `looked` gains what was found there.
fn first_usable(folder: &Path, looked: &mut Vec<String>) -> Option<PathBuf> {
    let mut found: Vec<PathBuf> = entries(folder).into_iter().filter(|f| is_it(f)).collect();
    found.sort_by_key(|path| std::cmp::Reverse(version_of(path)));
    if found.is_empty() {
        looked.push(format!("{}: no libonnxruntime", folder.display()));
    }
    for path in found {
        match Library::inspect(&path) {
            Ok(_) => return Some(path),
            Err(error) => looked.push(error.to_string()),
        }
    }
    None
}

/// Lists a folder by name; empty if it cannot be read.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    paths.sort_unstable();
    paths
}

/// Returns whether a file has the name of the library itself, not of its providers.
fn is_it(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if cfg!(windows) {
        return name == "onnxruntime.dll";
    }
    name.strip_prefix("libonnxruntime.").is_some_and(|rest| {
        rest == "so" || rest.starts_with("so.") || rest == "dylib" || rest.ends_with(".dylib")
    })
}

/// Returns the numbers in a file's name.
fn version_of(path: &Path) -> Vec<u32> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.split('.')
        .filter_map(|part| part.parse().ok())
        .collect()
}

/// Returns the system's library folders; Debian's depend on the architecture.
fn system_folders() -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = if cfg!(windows) {
        Vec::new()
    } else {
        let by_architecture = match std::env::consts::ARCH {
            "arm" => "arm-linux-gnueabihf".to_owned(),
            "x86" => "i386-linux-gnu".to_owned(),
            other => format!("{other}-linux-gnu"),
        };
        let names = [
            "/usr/local/lib",
            "/opt/homebrew/lib",
            "/usr/lib",
            "/usr/lib64",
        ];
        let debian = Path::new("/usr/lib").join(by_architecture);
        std::iter::once(debian)
            .chain(names.map(PathBuf::from))
            .collect()
    };
    folders.retain(|folder| folder.is_dir());
    folders
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::inference::testing::ort_library;
    use std::os::unix::fs::PermissionsExt;

    /// Writes a program that runs these lines of a shell.
    fn script(folder: &Path, lines: &str) -> PathBuf {
        let path = folder.join("python");
        std::fs::write(&path, format!("#!/bin/sh\n{lines}\n")).expect("written");
        let executable = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(&path, executable).expect("allowed");
        path
    }

    fn search<'a>(
        variable: &'a dyn Fn(&str) -> Option<OsString>,
        python: PathBuf,
        system: &[&Path],
    ) -> Search<'a> {
        Search {
            variable,
            python,
            patience: Duration::from_millis(300),
            system: system.iter().map(|path| path.to_path_buf()).collect(),
        }
    }

    #[test]
    fn a_flag_comes_before_our_variable_and_that_before_the_other() {
        let both = |name: &str| Some(OsString::from(format!("/from/{name}")));
        let one = |name: &str| (name == "ORT_DYLIB_PATH").then(|| OsString::from("/other"));
        let python = PathBuf::from("/no/python");
        let named = search(&both, python.clone(), &[]).find(Some(Path::new("/flag")));
        assert_eq!(named.expect("named"), Path::new("/flag"));
        let ours = search(&both, python.clone(), &[]).find(None);
        assert_eq!(ours.expect("set"), Path::new("/from/EDGEGAIT_ORT_LIB"));
        let other = search(&one, python, &[]).find(None);
        assert_eq!(other.expect("set"), Path::new("/other"));
    }

    #[test]
    fn all_places_are_listed_where_there_is_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let fake = folder.path().join("libonnxruntime.so.1.30.0");
        std::fs::write(&fake, "not a library").expect("written");
        std::fs::write(folder.path().join("libonnxruntime_providers_shared.so"), "")
            .expect("written");
        let prefix = |name: &str| (name == "VIRTUAL_ENV").then(|| OsString::from("/no/env"));
        let python = script(folder.path(), "exit 1");
        let error = search(&prefix, python, &[folder.path(), Path::new("/no/lib")])
            .find(None)
            .expect_err("none")
            .to_string();
        for line in [
            "a file by name: none given",
            "EDGEGAIT_ORT_LIB: not set",
            "ORT_DYLIB_PATH: not set",
            "VIRTUAL_ENV: no onnxruntime in it",
            "CONDA_PREFIX: not set",
            "python: has no onnxruntime (exit status: 1)",
            "libonnxruntime.so.1.30.0: expected a shared library (ELF), found another kind of file",
            "/no/lib: no libonnxruntime",
        ] {
            assert!(error.contains(line), "{line}: {error}");
        }
        assert!(!error.contains("providers"), "{error}");
    }

    #[test]
    fn a_python_that_does_not_answer_is_not_waited_for() {
        let folder = tempfile::tempdir().expect("a folder");
        // The sleeper outlives the shell that started it, and keeps its output open.
        let python = script(folder.path(), "sleep 20 & sleep 20");
        let asked = Instant::now();
        let error = search(&|_| None, python, &[]).find(None).expect_err("none");
        assert!(asked.elapsed() < Duration::from_secs(5));
        assert!(error.to_string().contains("no answer in 0.3 s"), "{error}");
    }

    mod with_ort {
        use super::*;

        #[test]
        #[ignore = "needs EDGEGAIT_ORT_LIB"]
        fn the_library_beside_a_python_package_is_found_without_importing_it() {
            let library = ort_library();
            let folder = tempfile::tempdir().expect("a folder");
            let place = "lib/python3.11/site-packages/onnxruntime";
            let capi = folder.path().join(place).join("capi");
            std::fs::create_dir_all(&capi).expect("made");
            std::fs::write(capi.join("libonnxruntime.so.9.9.9"), "not a library").expect("written");
            let linked = capi.join("libonnxruntime.so.1.31.1");
            std::os::unix::fs::symlink(library, &linked).expect("linked");

            let prefix = |name: &str| (name == "VIRTUAL_ENV").then(|| folder.path().into());
            let found = search(&prefix, "/no/python".into(), &[]).find(None);
            assert_eq!(found.expect("in the environment"), linked);

            let package = folder.path().join(place);
            let python = script(folder.path(), &format!("echo {}", package.display()));
            let found = search(&|_| None, python, &[]).find(None);
            assert_eq!(found.expect("beside the package"), linked);
            let found = search(&|_| None, "/no/python".into(), &[&capi]).find(None);
            assert_eq!(found.expect("in a system's folder"), linked);
        }
    }
}
