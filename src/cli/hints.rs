//! Adds flags to the library's errors, which name causes but no flags: the flag that an error is
//! about goes before the message, and flags that help go after it.

use crate::error::{
    ChoiceError, Error, EvaluateError, InferenceError, Remedy, SettingError, SweepError,
    TemplateOrigin, paths, visible,
};
use edgegait_core::silhouette::Size;
use std::fmt;

/// An error as the command shows it.
pub(super) struct WithFlags<'a>(pub &'a Error);

impl fmt::Display for WithFlags<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&visible(&self.with_runtime("--runtime ort --ort-lib PATH")))
    }
}

impl WithFlags<'_> {
    /// Returns the text, with these flags for a model that the embedded runtime does not run.
    pub(super) fn with_runtime(&self, other: &str) -> String {
        let Self(error) = self;
        if let Error::Within { files, error } = error {
            return format!("{}: {}", paths(files), Self(error).with_runtime(other));
        }
        let advice = way_out(error, other).map_or(String::new(), |advice| format!(" ({advice})"));
        format!("{}{error}{advice}", flag(error))
    }
}

/// Returns the flag that an error is about, and its value; only the dashes if both begin the message.
fn flag(error: &Error) -> String {
    use ChoiceError as C;
    match error {
        Error::Choice(error) => match error {
            C::Distance(metres) => format!("--distance-m {metres}: "),
            C::FieldOfView(degrees) => format!("--fov-deg {degrees}: "),
            C::Aim(place) => format!("--aim-m {place}: "),
            C::Setting { .. } => "--".into(),
            C::NoImage(_) | C::Augmented(_) => "--augment: ".into(),
            C::Crops { steps, rows, .. } => format!("--crop-steps {steps} --crop-rows {rows}: "),
            C::NotMeasured { .. } | C::UncutHasNoGei { .. } => "--max-gei-rmse: ".into(),
            C::CyclesAreRecorded(_) => "--cycles: ".into(),
            C::NoLibrary { .. } => "--runtime ort: ".into(),
            C::BareEmbedded => "--bare: ".into(),
            _ => String::new(),
        },
        Error::Sweep(SweepError::GeiError { asked, .. }) => format!("--max-gei-rmse {asked}: "),
        _ => String::new(),
    }
}

/// Returns advice in terms of flags; `runtime` are those of another runtime.
fn way_out(error: &Error, runtime: &str) -> Option<String> {
    use ChoiceError as C;
    let words = match error {
        Error::Input {
            remedy: Some(remedy),
            ..
        } => match remedy {
            Remedy::OnnxRuntime => return Some(format!("use {runtime}")),
            Remedy::NameAnimation => "use --clip",
            Remedy::StateFrameRate => "state the frame rate with --fps",
            Remedy::NamePerson => "choose one with --person",
            Remedy::RenameJoints => {
                "name them with --joints FILE.csv: the line name,known, and for each joint a line such as hip.L,LeftUpLeg"
            }
            Remedy::FolderIsSubject => {
                "--subject-from folder uses the folder's name for the subject"
            }
            Remedy::FrameAnew => "state their size with --size, or omit --as-stored",
            Remedy::NamedViews => "--named-views treats all of them as names",
            Remedy::OneModality => "choose one with --modality",
            Remedy::OtherTemplate => {
                "make another dataset with --template gei, or a tree with --format opengait"
            }
            Remedy::GiveBackground => {
                "give a picture of the empty scene, or a folder of several, with --background"
            }
        },
        Error::Inference(error) => return asked(error, runtime),
        Error::Choice(error) => match error {
            C::CycleNeedsParallelRays => "use --lens ortho, or --framing camera",
            C::Setting { problem, .. } => return for_setting(problem),
            C::SourcesDiffer { setting, .. } => {
                return Some(format!(
                    "--{setting} applies to packs and trees; a dataset is used as it is"
                ));
            }
            C::NotMeasured { .. } => {
                "use --framing height and --lens ortho, or choose --raster, --jitter and --frames-per-cycle yourself"
            }
            C::UncutHasNoGei { .. } => "omit --track clip, or use --max-error-mm",
            C::NoCondition { .. } => "--conditions",
            C::NoLibrary { .. } => "give its path with --ort-lib",
            C::BareEmbedded => "use --runtime ort",
            C::ForeignDataset(_) => "name another folder, or use --overwrite",
            C::IsThere(_) | C::OtherRun { .. } => "name another, or use --overwrite",
            C::Unfinished { .. } => "continue with --resume, or remove the folder",
            _ => return None,
        },
        Error::Sweep(error) => match error {
            SweepError::UncutHasNoCycle(_) => {
                "import it without --track clip, or choose others with --walks"
            }
            SweepError::UncutHasNoVariations(_) => "omit --cycle",
            _ => return None,
        },
        Error::Evaluate(error) => match error {
            EvaluateError::NoTake { .. } => {
                "rename takes, choose one walk of each person so that takes are made from it, or use another --protocol"
            }
            EvaluateError::NothingMade(_) => {
                "make sessions with `edgegait cohort --sessions 2`, or state takes to make of one in the protocol: \"made\""
            }
            EvaluateError::NoClass { .. } => "use --protocol first-take",
            EvaluateError::TooManyViews { .. } => "choose fewer with --views",
            _ => return None,
        },
        _ => return None,
    };
    Some(words.to_owned())
}

/// Returns the flags that help if a setting cannot have its value.
fn for_setting(problem: &SettingError) -> Option<String> {
    let words = match problem {
        SettingError::ColumnsShareScale { setting, value, .. } => {
            return Some(format!(
                "use --raster rows, or something other than --{setting} {value}"
            ));
        }
        SettingError::ColumnsSumFrames(_) => "use --raster rows",
        SettingError::ColumnsFrames(_) => "--frames-per-cycle",
        SettingError::RasterUnderCondition { .. } => "use --raster skia or rows",
        SettingError::EmbeddedProvider => "use --runtime ort",
        _ => return None,
    };
    Some(words.to_owned())
}

/// Returns the flags that a recognizer needs.
fn asked(error: &InferenceError, runtime: &str) -> Option<String> {
    match error {
        InferenceError::Contract { setting, asked, .. }
            if *setting == "size" && Size::ALL.iter().all(|size| size.name() != asked) =>
        {
            Some("only 50x30, 64x44 and 64x64 can be drawn".into())
        }
        InferenceError::Contract {
            setting,
            asked,
            origin,
            ..
        } => {
            let what = match origin {
                TemplateOrigin::Drawn => "use",
                TemplateOrigin::Dataset => "sweep another dataset with",
            };
            Some(format!("{what} --{setting} {asked}"))
        }
        InferenceError::Embedded { .. } => Some(format!("if the model is right, use {runtime}")),
        InferenceError::ViewUntrained { .. } => {
            Some("choose its viewpoints with --azimuth-deg and --elevation-deg".into())
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::sweep::{FramingMode, Lens, Raster, Settings};
    use crate::draw::template::Template;
    use std::path::Path;

    fn shown(error: impl Into<Error>) -> String {
        WithFlags(&error.into()).to_string()
    }

    fn refused(settings: Settings) -> String {
        shown(settings.check().expect_err("it cannot be drawn"))
    }

    #[test]
    fn a_setting_is_shown_as_its_flag_with_the_flag_that_helps() {
        let columns = Settings {
            rasterizer: Raster::Columns,
            ..Settings::default()
        };
        assert_eq!(
            refused(columns),
            "--raster columns: it draws all elevations of an azimuth in one pass, which needs one \
             scale and parallel rays, but framing height has a scale for each frame (use --raster rows, or something other than --framing height)"
        );
        let motion = Settings {
            template: Template::Mhi,
            framing: FramingMode::Camera,
            ..columns
        };
        assert_eq!(
            refused(motion),
            "--raster columns: it sums frames as it draws them, which makes a gei, not mhi (use \
             --raster rows)"
        );
        let cycle = Settings {
            framing: FramingMode::Cycle,
            lens: Lens::Persp,
            ..Settings::default()
        };
        assert!(refused(cycle).ends_with("(use --lens ortho, or --framing camera)"));
        let mut near = Settings::default();
        near.sensor.distance_m = 0.0;
        assert_eq!(
            refused(near),
            "--distance-m 0: expected a distance of 0.1 to 1,000,000 metres, found 0"
        );
    }

    #[test]
    fn what_a_contract_asks_for_is_shown_as_the_flag_that_gives_it() {
        let asked = |setting, asked: &str, origin| {
            shown(InferenceError::Contract {
                model: "m".into(),
                setting,
                asked: asked.into(),
                found: "x",
                origin,
            })
        };
        assert_eq!(
            asked("size", "64x44", TemplateOrigin::Drawn),
            "m: the model's contract asks for size 64x44, found x (use --size 64x44)"
        );
        assert!(
            asked("template", "mhi", TemplateOrigin::Dataset)
                .ends_with("found x (sweep another dataset with --template mhi)")
        );
        assert!(
            asked("size", "128x88", TemplateOrigin::Drawn)
                .ends_with("(only 50x30, 64x44 and 64x64 can be drawn)")
        );
    }

    #[test]
    fn a_remedy_and_a_way_out_are_shown_as_flags() {
        let model = Error::input("m.onnx", "it uses LRN").with_remedy(Remedy::OnnxRuntime);
        assert_eq!(
            shown(model),
            "m.onnx: it uses LRN (use --runtime ort --ort-lib PATH)"
        );
        let class = EvaluateError::NoClass {
            model: "m".into(),
            subject: "F01".into(),
        };
        assert_eq!(
            shown(class),
            "m: no class is called \"F01\", which scoring by classes needs (use --protocol first-take)"
        );
        assert_eq!(
            shown(Error::Missing("a window")),
            "expected a window, found none"
        );
    }

    /// Collects lines of the library's code with a flag, except git's flags and CSS variables.
    fn with_flag(folder: &Path, found: &mut Vec<String>) {
        let is_flag = |rest: &str| rest.starts_with(|first: char| first.is_ascii_lowercase());
        for entry in std::fs::read_dir(folder).expect("readable") {
            let path = entry.expect("readable").path();
            if path.is_dir() && !path.ends_with("cli") {
                with_flag(&path, found);
            } else if path.extension().is_some_and(|it| it == "rs") && !path.ends_with("build.rs") {
                let text = std::fs::read_to_string(&path).expect("text");
                let code = text.lines().filter(|line| !line.trim().starts_with("//"));
                let code = code.map(|line| line.replace("var(--", "var("));
                let lines = code.filter(|line| line.split("--").skip(1).any(is_flag));
                found.extend(lines.map(|line| format!("{}: {line}", path.display())));
            }
        }
    }

    #[test]
    fn the_library_names_no_flag() {
        let mut found = Vec::new();
        with_flag(
            &Path::new(env!("CARGO_MANIFEST_DIR")).join("src"),
            &mut found,
        );
        assert_eq!(found, [""; 0]);
    }
}
