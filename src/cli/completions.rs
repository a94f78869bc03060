//! `edgegait completions`: installs what shells and `man` read about the command.

use super::args::{Common, FileArgs};
use super::outputs::{Output, OutputKind};
use crate::error::{Error, Result};
use crate::files::{ResultHeader, write_bytes};
use clap::Command;
use clap_complete::{Shell, generate};
use clap_mangen::Man;
use serde::Serialize;
use std::path::PathBuf;

/// Install completions for bash, zsh and fish, and man pages
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  edgegait completions                         # for this user\n  edgegait completions --out /usr/local/share  # for everybody\n  edgegait completions --out package/usr/share # for a package\n\nbash needs its package bash-completion; man needs the folder man in MANPATH, unless bin beside it is in PATH."
)]
pub(super) struct CompletionsArgs {
    /// Folder of shared data, as the shells search it [default: $XDG_DATA_HOME or ~/.local/share]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    pub common: Common,
}

/// The shells, each with the place of its completions in a folder of shared data, and the beginning
/// of the file.
const SHELLS: [(Shell, &str, &str); 3] = [
    (
        Shell::Bash,
        "bash-completion/completions/edgegait",
        "_edgegait() {",
    ),
    (
        Shell::Zsh,
        "zsh/site-functions/_edgegait",
        "#compdef edgegait",
    ),
    (
        Shell::Fish,
        "fish/vendor_completions.d/edgegait.fish",
        "# Print an optspec",
    ),
];
/// The beginning of a man page.
const MAN_START: &str = ".ie \\n(.g .ds Aq \\(aq\n";

impl CompletionsArgs {
    fn folder(&self) -> Result<PathBuf> {
        self.out.clone().or_else(dirs::data_dir).ok_or_else(|| {
            Error::Usage("no folder of this user's data is known: expected --out DIR".into())
        })
    }

    /// Returns the files that the command writes.
    pub(super) fn files(&self) -> FileArgs {
        let folder = self.folder().unwrap_or_default();
        let output = |(place, start): (String, _)| {
            Output::new("--out", &folder.join(place), OutputKind::Begins(start))
        };
        let shells = SHELLS
            .iter()
            .map(|(_, place, start)| ((*place).to_owned(), *start));
        let pages = pages().into_iter();
        let pages = pages.map(|page| (place_of(&page), MAN_START));
        FileArgs {
            inputs: Vec::new(),
            outputs: shells.chain(pages).map(output).collect(),
        }
    }
}

/// Returns the command with what its help lists.
fn shown() -> Command {
    let command = super::command();
    let all = command.get_subcommands().filter(|one| !one.is_hide_set());
    Command::new("edgegait")
        .about(command.get_about().cloned().unwrap_or_default())
        .version(super::VERSION)
        .subcommands(all.cloned())
}

/// Returns the commands that have a page: `edgegait` itself, and each of its commands.
fn pages() -> Vec<Command> {
    let command = shown();
    let page = |one: &Command| {
        let name = one.get_name();
        let (page, bin) = (format!("edgegait-{name}"), format!("edgegait {name}"));
        one.clone().display_name(page).bin_name(bin)
    };
    let each: Vec<Command> = command.get_subcommands().map(page).collect();
    std::iter::once(command).chain(each).collect()
}

fn place_of(page: &Command) -> String {
    let name = page.get_display_name().unwrap_or("edgegait");
    format!("man/man1/{name}.1")
}

/// Runs the subcommand.
pub(super) fn run(args: &CompletionsArgs) -> Result<()> {
    let folder = args.folder()?;
    let mut command = shown();
    let write = |place: &str, bytes: &[u8]| write_bytes(folder.join(place), bytes);
    for (shell, place, _) in SHELLS {
        let mut script = Vec::new();
        generate(shell, &mut command, "edgegait", &mut script);
        write(place, &script)?;
    }
    for page in pages() {
        let place = place_of(&page);
        let mut text = Vec::new();
        Man::new(page)
            .render(&mut text)
            .map_err(|error| Error::io(&folder, error))?;
        write(&place, &text)?;
    }
    args.common.say(format_args!(
        "wrote completions and man pages into {}",
        folder.display()
    ));
    args.common.say(format_args!(
        "zsh: put fpath=({} $fpath) before compinit in ~/.zshrc",
        folder.join("zsh/site-functions").display()
    ));
    args.common.write_json(&Completions {
        header: ResultHeader::new("completions", args.common.seed),
        out: folder.display().to_string(),
    })
}

/// The results of the command.
#[derive(Serialize)]
struct Completions {
    #[serde(flatten)]
    header: ResultHeader,
    out: String,
}
