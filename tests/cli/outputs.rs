//! Outputs of the built command: checked before work, never written over an input, and removed
//! after an interruption.

use crate::command::*;
use crate::npy::npy;
#[cfg(target_os = "linux")]
use crate::signals::heeding_signals;
use crate::two::folder;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

#[test]
fn outputs_are_tried_before_any_work_and_nothing_is_left_behind() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("file"), "mine").expect("a file");
    fs::create_dir(at.join("there.egp")).expect("a folder");
    for arguments in [
        "score",
        "train",
        "bench",
        "confounders",
        "quantize m.onnx",
        "cohort",
        "frontier",
        "render two.egp",
        "segment frames --out tree",
        "sweep two.egp",
        "inspect two.egp",
        "import walk.bvh",
    ] {
        // No command gets to the point of reporting that m.onnx or walk.bvh is missing.
        let results = format!("{arguments} --json file/new/results.json");
        let arguments: Vec<&str> = results.split(' ').collect();
        let words = [
            "results.json: expected ",
            "file to be a folder, found a file",
        ];
        refused(at, &arguments, 1, &words);
    }
    for (arguments, out) in [
        ("score", "file/report"),
        ("score --probes-csv file/rows.csv", "report"),
        ("train", "file/m.onnx"),
        ("confounders", "file/chart.svg"),
        ("quantize m.onnx", "file/m.egr"),
        ("cohort", "file/people.egp"),
        ("frontier", "file/frontier"),
        ("render two.egp", "file/walk.npy"),
        ("segment frames", "file/tree"),
        ("sweep two.egp", "file/dataset"),
        ("import walk.bvh", "file/walk.egp"),
    ] {
        let all = format!("{arguments} --out {out}");
        let arguments: Vec<&str> = all.split(' ').collect();
        refused(at, &arguments, 1, &["file to be a folder, found a file"]);
    }
    let onto_a_folder = ["cohort", "--out", "there.egp"];
    refused(
        at,
        &onto_a_folder,
        2,
        &["expected a file to write, found a folder"],
    );
    let both = ["train", "--out", "m.onnx", "--json", "./m.toml"];
    refused(at, &both, 2, &["--out and --json: both would be"]);
    assert_eq!(names(at), ["file", "there.egp", "two.egp"]);
}

#[test]
fn an_input_is_never_written_over_even_when_asked() {
    let folder = folder();
    let at = folder.path();
    let pack = fs::read(at.join("two.egp")).expect("the pack");
    let sweep = ["sweep", "two.egp", "--views", "side", "--out", "side"];
    done(at, &sweep);
    let index = fs::read(at.join("side/index.csv")).expect("the index");
    fs::write(at.join("views.csv"), "azimuth_deg,elevation_deg\n90,0\n").expect("a file");
    #[cfg(unix)]
    std::os::unix::fs::symlink("two.egp", at.join("link.json")).expect("a link");
    for arguments in [
        "score two.egp --json two.egp",
        "score two.egp --json side/../two.egp",
        #[cfg(unix)]
        "inspect two.egp --json link.json",
        "score two.egp --views views.csv --probes-csv views.csv",
        "score side --json side/index.csv",
        "train side --json side/manifest.json",
        "sweep two.egp --out two.egp",
        "import two.egp --out two.egp",
    ] {
        let all = format!("{arguments} --overwrite");
        let arguments: Vec<&str> = all.split(' ').collect();
        refused(
            at,
            &arguments,
            2,
            &["which this command reads (name another)"],
        );
    }
    assert_eq!(fs::read(at.join("two.egp")).expect("the pack"), pack);
    assert_eq!(
        fs::read(at.join("side/index.csv")).expect("the index"),
        index
    );
}

#[test]
fn an_earlier_result_is_replaced_and_anything_else_only_when_asked() {
    let folder = folder();
    let at = folder.path();
    let train = "train two.egp --views side --cycles 2 --components 2 --out m.onnx";
    // Each is run twice; the second run finds its own output.
    for arguments in [
        "cohort --people 1 --speeds-kmh 5 --out new/folder/one.egp --json new/results.json",
        "render two.egp --out walk.png",
        "render two.egp --out walk.gif --azimuth-deg 0,90",
        "completions --out share",
        train,
        "score m.onnx two.egp --views side --probes-csv rows.csv --out report --json score.json",
        "inspect two.egp --json inspect.json",
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        done(at, &arguments);
        done(at, &arguments);
    }
    let words = ["already exists", "use --overwrite"];
    for (arguments, name) in [
        ("cohort --people 1 --speeds-kmh 5 --out mine", "mine"),
        ("render two.egp --out mine.png", "mine.png"),
        ("render two.egp --out mine.gif", "mine.gif"),
        (
            "completions --out share",
            "share/zsh/site-functions/_edgegait",
        ),
        // An array does not state which program made it.
        ("render two.egp --out mine.npy", "mine.npy"),
        (train, "m.toml"),
        ("inspect two.egp --json score.json", "score.json"),
        ("inspect two.egp --json mine.json", "mine.json"),
        (
            "score m.onnx two.egp --views side --out page --probes-csv other.csv",
            "page/index.html",
        ),
    ] {
        let path = at.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        if name != "score.json" {
            fs::write(&path, "mine = true\n").expect("a file");
        }
        let before = fs::read(&path).expect("a file");
        let arguments: Vec<&str> = arguments.split(' ').collect();
        refused(at, &arguments, 2, &words);
        assert_eq!(fs::read(&path).expect("a file"), before);
        done(at, &[&arguments[..], &["--overwrite"]].concat());
        assert_ne!(fs::read(&path).expect("a file"), before, "{name}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_table_is_printed_though_its_results_cannot_be_written_in_the_end() {
    let folder = folder();
    for arguments in [
        "inspect two.egp --json /dev/full",
        "cohort --people 1 --speeds-kmh 5 --out /dev/full",
        "score two.egp --walks walk-4kmh --views side --json /dev/full",
    ] {
        let output = edgegait(folder.path(), &arguments.split(' ').collect::<Vec<_>>());
        assert_eq!(code(&output), 1, "{arguments}");
        let error = text(&output.stderr);
        assert!(error.contains("error: /dev/full: No space left"), "{error}");
        let table = text(&output.stdout);
        assert!(
            table.contains("F01") || table.contains("rank-1 %"),
            "{table}"
        );
        assert!(!table.contains("wrote"), "{table}");
    }
}

/// Waits for a condition, for at most a minute.
#[cfg(target_os = "linux")]
fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    for _ in 0..600 {
        if is_so() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    panic!("it never came about: {what}");
}

#[test]
#[cfg(target_os = "linux")]
fn an_interrupted_sweep_leaves_what_was_there_and_what_it_can_go_on_with() {
    let folder = folder();
    let at = folder.path();
    let sweep = ["sweep", "two.egp", "--out", "walks", "--views", "side"];
    done(at, &sweep);
    let before = npy(at.join("walks/geis.npy")).1;
    for (signal, code_of_signal) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129)] {
        let mut child = heeding_signals()
            .args(["sweep", "two.egp", "--out", "walks", "--cycles", "1000"])
            .current_dir(at)
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("the command starts");
        let journal = at.join("walks.unfinished/journal.json");
        wait_until("it notes what is done", || journal.exists());
        let kill = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status();
        assert!(kill.expect("kill runs").success());
        let status = child.wait().expect("it ends");
        assert_eq!(status.code(), Some(code_of_signal));
        assert_eq!(names(at), ["two.egp", "walks", "walks.unfinished"]);
        fs::remove_dir_all(at.join("walks.unfinished")).expect("there");
        assert_eq!(npy(at.join("walks/geis.npy")).1, before);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_signal_that_was_ignored_at_the_start_stays_ignored() {
    let folder = folder();
    let at = folder.path();
    let program = env!("CARGO_BIN_EXE_edgegait");
    let sweep = format!(
        "trap '' HUP; exec env --default-signal=TERM {program} sweep two.egp --out walks --cycles 1000"
    );
    // As with `nohup`.
    let mut child = Command::new("sh")
        .args(["-c", &sweep])
        .current_dir(at)
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the command starts");
    let journal = at.join("walks.unfinished/journal.json");
    wait_until("it notes what is done", || journal.exists());
    for (signal, ends) in [("-HUP", false), ("-TERM", true)] {
        let kill = Command::new("kill")
            .args([signal, &child.id().to_string()])
            .status();
        assert!(kill.expect("kill runs").success());
        if ends {
            assert_eq!(child.wait().expect("it ends").code(), Some(143));
        } else {
            std::thread::sleep(std::time::Duration::from_millis(500));
            assert!(child.try_wait().expect("its state").is_none());
        }
    }
    assert_eq!(names(at), ["two.egp", "walks.unfinished"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_bench_that_dies_takes_the_process_that_measures_with_it() {
    let folder = folder();
    let at = folder.path();
    let temporary = at.join("temporary");
    fs::create_dir(&temporary).expect("a folder");
    let measuring = |parent: u32| -> Option<String> {
        // Of any of its threads.
        let threads = fs::read_dir(format!("/proc/{parent}/task")).ok()?.flatten();
        let mut children = threads.filter_map(|thread| {
            let children = fs::read_to_string(thread.path().join("children")).ok()?;
            children.split_whitespace().next().map(str::to_owned)
        });
        children.next()
    };
    for signal in ["-INT", "-KILL"] {
        let mut parent = heeding_signals()
            .args(["bench", "two.egp", "--window-s", "600"])
            .current_dir(at)
            .env("TMPDIR", &temporary)
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("the command starts");
        let mut child = None;
        wait_until("a process measures", || {
            child = measuring(parent.id());
            child.is_some()
        });
        let kill = Command::new("kill")
            .args([signal, &parent.id().to_string()])
            .status();
        assert!(kill.expect("kill runs").success());
        parent.wait().expect("it ends");
        let child = PathBuf::from("/proc").join(child.expect("one was found"));
        wait_until("the other process ends", || !child.exists());
        if signal == "-INT" {
            assert_eq!(names(&temporary), [""; 0]);
        }
    }
}

#[test]
fn completions_and_pages_know_the_flags_of_every_command() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let said = done(at, &["completions", "--out", "share"]);
    assert!(said.contains("fpath=(share/zsh/site-functions"), "{said}");
    let read = |place: &str| fs::read_to_string(at.join("share").join(place)).expect(place);
    for place in [
        "zsh/site-functions/_edgegait",
        "fish/vendor_completions.d/edgegait.fish",
        "man/man1/edgegait-render.1",
    ] {
        let text = read(place).replace('\\', "");
        assert!(text.contains("azimuth-deg"), "{place}");
        assert!(!text.contains("try-model"), "{place}");
    }
    let page = read("man/man1/edgegait.1");
    for command in ["edgegait-score(1)", "edgegait-completions(1)"] {
        assert!(page.replace('\\', "").contains(command), "{page}");
    }
    // What bash offers after the beginning of a flag, of a command, and of a value.
    for (words, offered) in [
        ("edgegait render --azi", "--azimuth-deg"),
        ("edgegait rend", "render"),
        ("edgegait render --raster skia-", "skia-aa"),
    ] {
        let script = "source share/bash-completion/completions/edgegait; COMP_WORDS=($0); \
            COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); \
            _edgegait edgegait ${COMP_WORDS[COMP_CWORD]} ${COMP_WORDS[COMP_CWORD - 1]}; \
            echo ${COMPREPLY[@]}";
        let shell = Command::new("bash")
            .args(["-c", script, words])
            .current_dir(at)
            .output();
        let Ok(shell) = shell else {
            continue;
        };
        assert_eq!(text(&shell.stdout).trim(), offered, "{words}");
    }
}
