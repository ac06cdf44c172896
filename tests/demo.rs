//! The demonstration as a user sees it: the built program, a folder of its own, the printed tables.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::Path,
    process::{Command, Output, Stdio},
};

/// The generator, so that the committed grids can be made anew.
#[path = "../examples/make_flank_grid.rs"]
#[expect(dead_code, reason = "its main is for `cargo run --example`")]
mod make_flank_grid;

fn demo(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .arg("demo")
        .args(arguments)
        .current_dir(folder)
        .env("FLANKFIT_BIND", "127.0.0.1:0")
        .output()
        .unwrap()
}

fn printed(output: &Output) -> String {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}\n{errors}\n{text}", output.status);
    text
}

/// The cells of a table's row, found by the text in its first column under a heading.
fn row<'a>(text: &'a str, heading: &str, first: &str) -> Vec<&'a str> {
    let (_, section) = text.split_once(heading).unwrap_or_else(|| panic!("no \"{heading}\" in\n{text}"));
    let line = section.lines().find(|line| line.trim_start().starts_with(&format!("{first} ")));
    line.unwrap_or_else(|| panic!("no row \"{first}\" under \"{heading}\" in\n{text}"))
        .trim()
        .split("  ")
        .map(str::trim)
        .filter(|cell| !cell.is_empty())
        .collect()
}

fn number(cell: &str) -> f64 {
    cell.replace('−', "-").parse().unwrap_or_else(|_| panic!("\"{cell}\" is not a number"))
}

/// One screen: the page's address first, results of both flanks against their limits, what to
/// change, what the nodes do not determine, and how the machine responded.
#[test]
fn the_bundled_gear_is_measured_corrected_and_accepted_on_one_screen() {
    let folder = tempfile::tempdir().unwrap();
    let text = printed(&demo(folder.path(), &["--exit"]));
    assert!(folder.path().join("flankfit-demo.db").is_file(), "the jobs are in a file");
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines.len() <= 32 && lines.iter().all(|line| line.chars().count() <= 120), "{text}");
    assert!(lines[1].starts_with("Open http://") && lines[1].contains("/jobs/"), "{text}");

    // The estimates recover the known surface: slopes of 9 and 8.4 µm, then 0.5 and −0.1 µm;
    // crownings and twist unchanged.
    for (symbol, truth) in [
        ("f_Hα", [9.0, 8.4, 0.5, -0.1]),
        ("f_Hβ", [0.0; 4]),
        ("C_α", [3.0, 3.4, 3.0, 3.4]),
        ("C_β", [4.0, 4.4, 4.0, 4.4]),
        ("S", [3.0, -1.5, 3.0, -1.5]),
    ] {
        let cells = row(&text, "µm, along the normal", symbol);
        let measured = [cells.len() - 5, cells.len() - 4, cells.len() - 2, cells.len() - 1].map(|i| cells[i]);
        for (k, (cell, truth)) in measured.into_iter().zip(truth).enumerate() {
            let (value, rest) = cell.split_once(" ± ").unwrap();
            assert!((number(value) - truth).abs() < 0.9, "{symbol} {cells:?}");
            let within = !(symbol == "f_Hα" && k < 2);
            assert!(rest.ends_with(if within { '✓' } else { '✗' }), "{symbol} {cells:?}");
        }
    }
    // only the pressure angle needs a change
    let (_, changes) = text.split_once("Changes of the machine\n").unwrap();
    let first = changes.lines().next().unwrap();
    assert!(
        first.trim().starts_with("profile angle")
            && number(first.split_whitespace().nth(2).unwrap().trim_end_matches('′')) > 5.0,
        "{text}"
    );
    assert!(changes.lines().nth(1).unwrap().contains("left alone"), "{text}");
    assert!(text.contains("tooth thickness, infeed, tool axis offset") && changes.contains("as predicted"), "{text}");
}

#[test]
fn verbose_prints_the_tables_of_every_fit() {
    let folder = tempfile::tempdir().unwrap();
    let text = printed(&demo(folder.path(), &["--exit", "--verbose"]));

    // Coefficients: value, standard error, bias bound, least squares, interval, unit.
    for (term, unit) in [("1", "µm"), ("u", "µm/mm"), ("u^2*v^2", "µm/mm⁴")] {
        let cells = row(&text, "Coefficients", term);
        assert_eq!(cells.len(), 7, "{cells:?}");
        assert!(number(cells[2]) > 0.0 && number(cells[3]) >= 0.0, "{cells:?}");
        let (low, high) = cells[5].split_once(" to ").unwrap();
        assert!(number(low) < number(cells[4]) && number(cells[4]) < number(high), "{cells:?}");
        assert_eq!(cells[6], unit);
    }
    // 135 nodes, 3 missing, 9 coefficients.
    assert!(text.contains("132 nodes, 123 degrees of freedom"), "{text}");

    // The smallest eigenvalue before and after.
    let first = row(&text, "Spectrum of the scaled Fisher information matrix", "1");
    assert!(number(first[1]) > 0.0 && number(first[2]) >= number(first[1]), "{first:?}");

    // Every criterion is listed with least squares.
    for criterion in ["least_squares", "min_mse", "min_condition", "gcv", "discrepancy", "l_curve"] {
        let cells = row(&text, "λ* as each criterion would choose it", criterion);
        let rms = cells.len() - 1 - usize::from(cells.last() == Some(&"← this fit"));
        assert!(number(cells[rms]) > 0.0, "{cells:?}");
    }
    assert!(text.contains("nearly"), "a sentence on collinearity:\n{text}");

    let (_, trace) = text.split_once("Trace of the job").unwrap();
    let order =
        ["fit 1 by min_mse", "fit 2 by ", " is chosen", "decision: remachine", "fit 1 by min_mse", "decision: accept"];
    let mut rest = trace;
    for event in order {
        let split = rest.split_once(event);
        (_, rest) = split.unwrap_or_else(|| panic!("\"{event}\" is missing or out of order in\n{trace}"));
    }
}

#[test]
fn a_second_run_adds_a_job_to_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let database = format!("sqlite://{}", folder.path().join("jobs.db").display());
    for _ in 0..2 {
        let text = printed(&demo(folder.path(), &["--exit", "--database", &database]));
        assert!(text.contains("Changes of the machine"), "{text}");
    }
    assert!(!folder.path().join("flankfit-demo.db").exists());
}

#[test]
fn real_traces_are_fitted_flank_by_flank() {
    let traces = Path::new(env!("CARGO_MANIFEST_DIR")).join("engine/tests/data/p40/97340-neu_nodes.csv");
    let folder = tempfile::tempdir().unwrap();
    let text = printed(&demo(folder.path(), &["--exit", "--nodes", &traces.display().to_string()]));
    for flank in ["left flank of tooth 1", "right flank of tooth 1"] {
        assert!(text.contains(flank), "{text}");
    }
    // Six traces of 40 samples; the first sample of each lead is undefined.
    assert_eq!(text.matches("237 nodes, 228 degrees of freedom").count(), 2, "{text}");
    assert!(text.contains("Not used: teeth 12, 22"), "{text}");
    assert!(text.contains("Leads turned"), "the right flank's leads count against material:\n{text}");
    assert!(text.contains("The decision is left to you"), "{text}");
}

/// Every file of `examples/files` with nodes or traces: all but points, which need their gear.
#[test]
fn every_shipped_file_of_nodes_is_shown() {
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/files");
    let mut files: Vec<_> = std::fs::read_dir(files).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| !["README.md", "points.txt"].iter().any(|other| file.ends_with(other)));
    assert!(files.len() >= 7, "{}", files.len());
    for file in files {
        let folder = tempfile::tempdir().unwrap();
        let text = printed(&demo(folder.path(), &["--exit", "--nodes", file.to_str().unwrap()]));
        assert!(text.contains("The decision is left to you"), "{}: {text}", file.display());
        let is_cross = ["curves.mka", "rexs_1.2.rexs", "rexs_2.0.rexs"].iter().any(|name| file.ends_with(name));
        assert_eq!(
            text.contains("a plane: its nodes do not determine a twist"),
            is_cross,
            "{}: {text}",
            file.display()
        );
    }
}

#[test]
fn own_nodes_in_csv_are_taken() {
    let folder = tempfile::tempdir().unwrap();
    let mut nodes = "x,y\n".to_owned();
    for k in 0..12 {
        let x = f64::from(k);
        let height =
            if k == 5 { String::new() } else { (1.0 + 0.1 * x - 0.02 * x * x + 0.01 * (7.0 * x).sin()).to_string() };
        nodes += &format!("{x},{height}\n");
    }
    std::fs::write(folder.path().join("profile.csv"), nodes).unwrap();
    let text = printed(&demo(folder.path(), &["--exit", "--nodes", "profile.csv"]));
    assert!(text.contains("11 nodes used, 1 missing"), "{text}");
    assert!(text.contains("The decision is left to you"), "{text}");
}

#[test]
fn unusable_files_and_addresses_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let output = demo(folder.path(), &["--exit", "--nodes", "nowhere.csv"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && error.contains("cannot read nowhere.csv"), "{error}");

    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let output = demo(folder.path(), &["--exit", "--bind", &address]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && error.contains(&address) && error.contains("taken"), "{error}");
}

#[test]
fn the_committed_grids_match_the_generator() {
    for flank in &make_flank_grid::FLANKS {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(flank.file);
        let committed = std::fs::read_to_string(&path).unwrap();
        assert!(committed == make_flank_grid::fit_request(flank), "{} differs: run the example", path.display());
    }
}

#[test]
fn the_closed_loop_converges_where_least_squares_runs_away() {
    let folder = tempfile::tempdir().unwrap();
    let text = printed(&demo(folder.path(), &["--closed-loop", "--exit"]));
    let rms = |heading: &str, iteration: &str| number(row(&text, heading, iteration)[2]);
    assert!(rms("Spectral", "1") > 5.0 && rms("Spectral", "3") < 0.5, "{text}");
    assert!(rms("Plain least squares", "3") > 10.0 * rms("Plain least squares", "1"), "{text}");
    assert!(number(row(&text, "Of 100 such machines", "spectral_uncertainty")[1]) >= 99.0, "{text}");
    assert!(text.contains("correction 1: The machine responded as predicted"), "{text}");
    // what ran away is not said to have been foreseen
    let (_, runaway) = text.split_once("Plain least squares").unwrap();
    assert!(
        runaway.contains("correction 1: The measurement cannot show") && !runaway.contains("responded as predicted"),
        "{text}"
    );
}

/// If the server stays up, the output ends with the page of its job.
#[test]
fn the_last_line_leads_to_the_job_in_the_dashboard() {
    let folder = tempfile::tempdir().unwrap();
    let mut server = Command::new(env!("CARGO_BIN_EXE_flankfit"))
        .args(["demo", "--bind", "127.0.0.1:0"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(server.stdout.take().unwrap()).lines().map(Result::unwrap);
    let line = lines.map(|line| line.trim().to_owned()).find(|line| line.starts_with("dashboard"));
    let address = line.as_deref().and_then(|line| line.split_once("http://")).map(|(_, address)| address);
    let page = address.and_then(|address| address.split_once('/')).map(|(host, path)| {
        let mut stream = TcpStream::connect(host).unwrap();
        write!(stream, "GET /{path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        (path, answer)
    });
    server.kill().unwrap();
    server.wait().unwrap();
    let (path, answer) = page.unwrap_or_else(|| panic!("{line:?}"));
    assert!(path.starts_with("jobs/") && path.len() == "jobs/".len() + 36, "{path}");
    assert!(answer.starts_with("HTTP/1.1 200 ") && answer.contains("<div id=\"app\">"), "{answer}");
}

/// Every fit request in `examples`, including those whose regularisation has no parameter for a
/// criterion.
#[test]
fn every_shipped_fit_request_is_shown() {
    let requests = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/requests");
    let mut files: Vec<_> = std::fs::read_dir(requests).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.file_name().unwrap().to_string_lossy().starts_with("fit_"));
    assert!(files.len() >= 42, "{}", files.len());
    for file in files {
        let folder = tempfile::tempdir().unwrap();
        let output = demo(folder.path(), &["--exit", "--nodes", file.to_str().unwrap()]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {errors}", file.display());
        assert!(String::from_utf8_lossy(&output.stdout).contains("Trace of the job"), "{}", file.display());
    }
}

/// `flankfit openapi | head` does not fail.
#[test]
fn a_reader_that_leaves_ends_the_program_quietly() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&["openapi"][..], &["demo", "--exit", "--bind", "127.0.0.1:0"]] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_flankfit"))
            .args(arguments)
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(program.stdout.take());
        let ended = program.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert!(ended.status.success() && said.is_empty(), "{arguments:?}: {} {said}", ended.status);
    }
}

/// Errors name the file and the place in it.
#[test]
fn errors_in_a_file_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        file.to_str().unwrap().to_owned()
    };
    let table = write("nodes.csv", "u,v,z\n1,2,three\n");
    let request =
        write("request.json", r#"{"nodes":{"type":"curve","x":[1,2],"y":[1,"a"]},"model":{"type":"linear"}}"#);
    let curves = write("curves.mka", "HEADER");
    let gear = write("gear.json", r#"{"teeth":0}"#);
    for (arguments, parts) in [
        (&["fit", &table][..], &["nodes.csv: 1 cell is not a finite number", "line 2, column 3"][..]),
        (&["fit", &request], &["request.json: nodes.y.1: expected a number"]),
        (&["evaluate", &curves, "--gear", &gear], &["gear.json: teeth: ", "gear.json: normal_module_mm: required"]),
        (&["evaluate", &curves], &["curves.mka: "]),
        (&["evaluate", "missing.mka"], &["cannot read missing.mka"]),
    ] {
        let run = Command::new(env!("CARGO_BIN_EXE_flankfit")).args(arguments).current_dir(folder.path()).output();
        let run = run.unwrap();
        let said = String::from_utf8(run.stderr).unwrap();
        assert!(!run.status.success() && run.stdout.is_empty(), "{arguments:?}: {said}");
        assert!(parts.iter().all(|part| said.contains(part)) && !said.contains('{'), "{arguments:?}: {said}");
    }
}

/// The `spec` of a response with the nodes is a valid request with the same response.
#[test]
fn a_spec_with_its_nodes_gives_the_same_fit() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let fit = |file: &Path| {
        let run = Command::new(env!("CARGO_BIN_EXE_flankfit")).arg("fit").arg(file).output().unwrap();
        serde_json::from_slice::<serde_json::Value>(&run.stdout).unwrap()
    };
    let file = root.join("examples/flank_z52.json");
    let response = fit(&file);
    let request: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let mut again = response["spec"].clone();
    again["nodes"] = request["nodes"].clone();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("again.json");
    std::fs::write(&file, again.to_string()).unwrap();
    assert_eq!(fit(&file), response);
}
