//! `flankfit study` as a user runs it, and its tables in the documents.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
    time::{Duration, Instant},
};

fn study(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_flankfit")).arg("study").args(arguments).output().unwrap()
}

#[test]
fn the_tables_of_the_document_match_the_output() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = study(&[]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "where there is no terminal there is no progress bar");
    let document = std::fs::read_to_string(root.join("docs/explanation/paper-figures.md")).unwrap();
    let mut said = 0;
    for line in text.lines().skip_while(|line| !line.contains("B of level k")).filter(|line| !line.contains("─")) {
        assert!(document.contains(line.trim()), "{line}");
        said += usize::from(!line.is_empty());
    }
    assert_eq!(said, 1 + 18 + 3, "heads, levels, the best one, the plateau, the least condition on it");
}

/// Section 6.3: about 5 times more accurate, a condition about 1e9 times less.
#[test]
fn the_default_study_reaches_the_papers_figures() {
    let body: serde_json::Value = serde_json::from_slice(&study(&["--json"]).stdout).unwrap();
    let level = body["levels"].as_array().unwrap().iter().find(|level| level["level"] == 2e-5).unwrap();
    let reference = &body["references"]["least_squares"];
    let ratio = |field: &str| reference[field]["median"].as_f64().unwrap() / level[field]["median"].as_f64().unwrap();
    assert!((4.2..5.5).contains(&ratio("bias_norm_squared").sqrt()), "{}", ratio("bias_norm_squared").sqrt());
    assert!((8e8..9e8).contains(&ratio("condition")), "{}", ratio("condition"));
    assert!((1.25..1.4).contains(&ratio("rss").recip()), "{}", ratio("rss"));
    // and the caveat: A lies along V₁, the error is A itself
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert!((number(&body["along_smallest"]) - 0.9998).abs() < 5e-5);
    let left = number(&level["bias_norm_squared"]["median"]) / number(&body["coefficient_norm_squared"]);
    assert!((left - 1.0).abs() < 1e-3, "{left}");
    // the plateau holds that level, and B of a level has less error than noise of the same
    let [low, high] = [0, 1].map(|at| number(&body["optimum"]["plateau"][at]));
    assert!(low < 2e-5 && 2e-5 < high);
    let calm = &body["optimum"]["least_condition"];
    assert!(number(&calm["condition_ratio"]) >= ratio("condition") && number(&calm["level"]) == high);
    let small = body["levels"].as_array().unwrap().iter().find(|level| level["level"] == 3e-9).unwrap();
    let error = |figures: &serde_json::Value| number(&figures["bias_norm_squared"]["median"]);
    assert!(error(&small["matrix_b"]) < error(small));
}

#[test]
fn a_study_of_ones_own() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/requests/study_matrix.json");
    let output = study(&[file.to_str().unwrap(), "--json"]);
    let body: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(body["levels"].as_array().unwrap().len(), 5);
    let folder = tempfile::tempdir().unwrap();
    let broken = folder.path().join("broken.json");
    std::fs::write(&broken, r#"{"x":[[1]],"levels":[0.1],"repetitions":1}"#).unwrap();
    let output = study(&[broken.to_str().unwrap()]);
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("/coefficients"));
    assert!(!study(&["/no/such/file.json"]).status.success());
}

/// A study in a folder, as files of its parts.
struct InParts {
    folder: tempfile::TempDir,
    request: PathBuf,
}

impl InParts {
    fn of(text: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let request = folder.path().join("request.json");
        fs::write(&request, text).unwrap();
        InParts { folder, request }
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    fn request(&self) -> &str {
        self.request.to_str().unwrap()
    }

    /// Computes a part into a file.
    #[track_caller]
    fn part(&self, which: &str, name: &str) -> String {
        let file = self.path(name);
        let output = study(&[self.request(), "--repetitions", which, "--raw", &file]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        file
    }
}

/// Message of the failed command on its one line.
#[track_caller]
fn refused(arguments: &[&str]) -> String {
    let output = study(arguments);
    assert!(!output.status.success() && output.stdout.is_empty());
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(said.lines().count(), 1, "{said}");
    said
}

const MATRIX: &str = include_str!("../examples/requests/study_matrix.json");

#[test]
fn parts_in_any_order_are_the_whole() {
    let own = InParts::of(MATRIX);
    let parts = [("0..1", "a"), ("1..47", "b"), ("47..60", "c"), ("60..100", "d")].map(|(of, name)| own.part(of, name));
    let [a, b, c, d] = parts.each_ref().map(String::as_str);
    let whole = study(&[own.request(), "--json"]).stdout;
    assert!(whole.starts_with(b"{\"count\":12,"));
    for order in [[a, b, c, d], [d, c, b, a], [c, a, d, b]] {
        let joined = study(&[&["join", "--json"][..], &order[..]].concat());
        assert!(joined.status.success(), "{}", String::from_utf8_lossy(&joined.stderr));
        assert!(joined.stdout == whole, "{order:?}");
    }
    // tables and a file likewise
    let answer = own.path("answer");
    let joined = study(&["join", d, b, a, c, "--output", &answer]);
    assert!(joined.status.success() && joined.stdout.is_empty());
    assert!(fs::read(&answer).unwrap() == study(&[own.request()]).stdout);
}

/// Columns that nearly depend on each other, the study that ships, in equal parts in a folder, as
/// the Job of deploy/studies has them.
#[test]
fn equal_parts_of_a_folder_are_the_whole() {
    let own = InParts::of(include_str!("../examples/requests/study_flank.json"));
    let folder = own.path("parts");
    fs::create_dir(&folder).unwrap();
    for index in 0..3 {
        own.part(&format!("{index}/3"), &format!("parts/{index}.zst"));
    }
    // what another program, or a part that was given up, left behind
    fs::write(format!("{folder}/.tmpX"), "half").unwrap();
    assert!(study(&["join", &folder, "--json"]).stdout == study(&["--json"]).stdout);
    // a part that is computed once more is the same file
    let first = fs::read(format!("{folder}/1.zst")).unwrap();
    own.part("1/3", "parts/1.zst");
    assert!(fs::read(format!("{folder}/1.zst")).unwrap() == first);
}

#[test]
fn levels_at_which_columns_depend_are_joined_as_well() {
    let own = InParts::of(
        r#"{"x":[[1,1],[2,2],[3,3],[4,4]],"coefficients":[1,2],"noise_sigma":0.1,"levels":[0,0.1],"repetitions":6}"#,
    );
    let (a, b) = (own.part("0..2", "a"), own.part("2..6", "b"));
    let whole = study(&[own.request(), "--json"]).stdout;
    let body: serde_json::Value = serde_json::from_slice(&whole).unwrap();
    assert!(body["levels"][0]["condition"].is_null() && body["levels"][1]["condition"].is_object());
    assert!(study(&["join", &b, &a, "--json"]).stdout == whole);
}

#[test]
fn incomplete_parts_are_refused_in_one_sentence() {
    let own = InParts::of(MATRIX);
    let (a, b, c) = (own.part("0..40", "a"), own.part("40..60", "b"), own.part("70..100", "c"));
    let said = refused(&["join", &c, &a]);
    assert!(said.contains("of 100 repetitions these are missing: 40..70"), "{said}");
    assert!(refused(&["join", &b]).contains("missing: 0..40, 60..100"));
    // one twice, and one within another
    assert!(refused(&["join", &a, &b, &a]).contains("both have the repetitions 0..40"));
    let within = own.part("10..20", "within");
    let said = refused(&["join", &b, &within, &a, &c]);
    assert!(said.contains(&format!("{a} and {within} both have the repetitions 10..20")), "{said}");
    // of a request that differs in its seed alone
    let other = InParts::of(&MATRIX.replace("\"seed\": 7", "\"seed\": 8"));
    let foreign = other.part("40..100", "foreign");
    let said = refused(&["join", &a, &foreign]);
    assert!(said.contains(&format!("{foreign} is of another study than {a}")), "{said}");
    // another program's file, one that is cut off at each of some places, one with another byte
    assert!(refused(&["join", own.request()]).contains("is no file of repetitions"));
    let whole = fs::read(&a).unwrap();
    let broken = own.path("broken");
    for length in [whole.len() / 2, whole.len() - 4, whole.len() - 1] {
        fs::write(&broken, &whole[..length]).unwrap();
        let said = refused(&["join", &broken, &b]);
        assert!(said.contains(&broken) && said.contains("compute its repetitions anew"), "{said}");
    }
    let text = String::from_utf8(zstd::decode_all(&whole[..]).unwrap()).unwrap();
    for (place, by) in [("\"rss\":0", "\"rss\":1"), ("\"to\":40", "\"to\":41"), ("seed", "need")] {
        assert!(text.contains(place), "{place}");
        fs::write(&broken, zstd::encode_all(text.replacen(place, by, 1).as_bytes(), 3).unwrap()).unwrap();
        let said = refused(&["join", &broken, &b]);
        assert!(said.contains("cut off or damaged"), "{place}: {said}");
    }
    let later = text.replacen("\"version\":1", "\"version\":2", 1);
    fs::write(&broken, zstd::encode_all(later.as_bytes(), 3).unwrap()).unwrap();
    assert!(refused(&["join", &broken]).contains("is of version 2; this program reads version 1"));
    // repetitions that there are not, and a folder without files
    let raw = own.path("raw");
    let said = refused(&[own.request(), "--repetitions", "90..101", "--raw", &raw]);
    assert!(said.contains("the study has 100 repetitions, so not all of 90..101"), "{said}");
    assert!(!Path::new(&raw).exists());
    fs::create_dir(&raw).unwrap();
    assert!(refused(&["join", &raw]).contains("there is no file to join"));
    // both or neither, and no tables of a part
    for arguments in
        [&["--repetitions", "0..1"][..], &["--raw", "x"], &["--repetitions", "0..1", "--raw", "x", "--json"]]
    {
        assert!(!study(arguments).status.success(), "{arguments:?}");
    }
    assert!(!Path::new("x").exists());
}

/// A study in a file, on one core: so it takes long where there are many, too.
fn on_one_core(file: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_flankfit"));
    command.args(["study", file.to_str().unwrap(), "--json"]).env("RAYON_NUM_THREADS", "1");
    command
}

/// A study of so many levels, in a folder.
fn study_of(levels: u32, folder: &Path) -> PathBuf {
    let file = folder.join("long.json");
    let row = |i: u32| [1.0, 0.1 * f64::from(i), 0.1 * f64::from(i) + 0.02 * f64::from(i).sin()];
    let level = |level: u32| 0.3 * f64::from(level) / f64::from(levels);
    let request = serde_json::json!({
        "x": (0..8).map(row).collect::<Vec<_>>(), "coefficients": [1.0, 0.5, 0.5], "noise_sigma": 0.05,
        "levels": (0..levels).map(level).collect::<Vec<_>>(), "repetitions": 10_000, "seed": 7, "scaling": "unit_length",
    });
    fs::write(&file, request.to_string()).unwrap();
    file
}

#[test]
fn long_runs_show_a_bar_only_on_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    // the time is that of the levels, and 200, as many as there may be, take several seconds
    for levels in [40, 100, 200] {
        let file = study_of(levels, folder.path());
        let begun = Instant::now();
        let output = on_one_core(&file).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !output.stdout.is_empty() && said.is_empty(), "{said}");
        // a bar is shown after the first second
        if begun.elapsed() < Duration::from_millis(2500) {
            continue;
        }
        #[cfg(target_os = "linux")]
        {
            let shown = on_a_terminal(&file);
            if shown.is_empty() {
                // quicker than before
                continue;
            }
            assert!(shown.contains("study ") && shown.contains(" % "), "{shown:?}");
            assert!(shown.ends_with("\u{1b}[2K"), "nothing is left behind: {shown:?}");
        }
        return;
    }
    panic!("no study took long enough for a bar");
}

/// Output of a study on standard error if that is a terminal.
#[cfg(target_os = "linux")]
fn on_a_terminal(file: &Path) -> String {
    use rustix::pty::{OpenptFlags, ioctl_tiocgptpeer, openpt, unlockpt};
    use std::{io::Read as _, process::Stdio};
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let own = openpt(flags).unwrap();
    unlockpt(&own).unwrap();
    let terminal = ioctl_tiocgptpeer(&own, flags).unwrap();
    let mut child = on_one_core(file)
        .env("TERM", "xterm")
        .env_remove("NO_COLOR")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(terminal)
        .spawn()
        .unwrap();
    let (mut own, mut shown, mut some) = (fs::File::from(own), Vec::new(), [0; 4096]);
    // once nobody has the terminal any more, reading it is an error
    while let Ok(length @ 1..) = own.read(&mut some) {
        shown.extend_from_slice(&some[..length]);
    }
    assert!(child.wait().unwrap().success());
    String::from_utf8(shown).unwrap()
}
