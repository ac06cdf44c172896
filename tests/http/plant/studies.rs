//! The Jobs of `deploy/studies`, with their own commands: what the pods write is joined to the
//! answer of the whole study.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use serde_json::Value;

use super::yaml;

fn manifest(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("deploy/studies").join(name);
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(text.starts_with("# Untried in a cluster."), "{name}");
    let mut documents = yaml::documents(&text);
    assert_eq!(documents.len(), 1, "{name}");
    documents.remove(0)
}

#[track_caller]
fn at<'a>(value: &'a Value, pointer: &str) -> &'a Value {
    value.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is missing in {value}"))
}

/// Runs the command of a container, its folders being those of a temporary one.
fn run(job: &Value, folder: &Path, index: Option<u64>) -> Output {
    let arguments = at(job, "/spec/template/spec/containers/0/args").as_array().unwrap();
    let arguments = arguments.iter().map(|argument| {
        let argument = argument.as_str().unwrap();
        let placed =
            if argument.starts_with('/') { format!("{}{argument}", folder.display()) } else { argument.into() };
        match index {
            Some(index) => placed.replace("$(JOB_COMPLETION_INDEX)", &index.to_string()),
            None => placed,
        }
    });
    Command::new(env!("CARGO_BIN_EXE_flankfit")).args(arguments).output().unwrap()
}

#[test]
fn the_pods_of_a_study_compute_it_whole() {
    let (parts, join, volume) = (manifest("parts.yaml"), manifest("join.yaml"), manifest("volume.yaml"));
    let spec = at(&parts, "/spec");
    assert_eq!(at(spec, "/completionMode"), "Indexed");
    let completions = at(spec, "/completions").as_u64().unwrap();
    assert!((1..=completions).contains(&at(spec, "/parallelism").as_u64().unwrap()));
    let folder = tempfile::tempdir().unwrap();
    for name in ["study", "parts"] {
        fs::create_dir(folder.path().join(name)).unwrap();
    }
    let request = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/requests/study_matrix.json");
    fs::copy(&request, folder.path().join("study/request.json")).unwrap();
    for index in 0..completions {
        // a part is missing until it is there
        let early = run(&join, folder.path(), None);
        assert!(!early.status.success() && early.stdout.is_empty());
        let done = run(&parts, folder.path(), Some(index));
        assert!(done.status.success(), "{index}: {}", String::from_utf8_lossy(&done.stderr));
    }
    let joined = run(&join, folder.path(), None);
    assert!(joined.status.success(), "{}", String::from_utf8_lossy(&joined.stderr));
    let whole = Command::new(env!("CARGO_BIN_EXE_flankfit")).arg("study").arg(&request).arg("--json").output().unwrap();
    assert!(whole.status.success() && joined.stdout == whole.stdout);

    // each mounts the volume there is, writes only where it may, and is as the servers' pods are
    for job in [&parts, &join] {
        assert_eq!((at(job, "/apiVersion"), at(job, "/kind")), (&Value::from("batch/v1"), &Value::from("Job")));
        let pod = at(job, "/spec/template/spec");
        let claims: Vec<&Value> = at(pod, "/volumes")
            .as_array()
            .unwrap()
            .iter()
            .filter_map(|volume| volume.pointer("/persistentVolumeClaim/claimName"))
            .collect();
        assert_eq!(claims, [at(&volume, "/metadata/name")]);
        assert_eq!(at(&volume, "/spec/accessModes/0"), "ReadWriteMany");
        let volumes: Vec<&Value> = at(pod, "/volumes").as_array().unwrap().iter().map(|v| &v["name"]).collect();
        let mounts = at(pod, "/containers/0/volumeMounts").as_array().unwrap();
        assert!(mounts.iter().map(|mount| &mount["name"]).eq(volumes.iter().copied()));
        assert_eq!(at(pod, "/restartPolicy"), "Never");
        assert_eq!(at(pod, "/securityContext/runAsNonRoot"), true);
        assert_eq!(at(pod, "/securityContext/fsGroup"), at(pod, "/securityContext/runAsUser"));
        assert_eq!(at(pod, "/containers/0/securityContext/readOnlyRootFilesystem"), true);
        assert_eq!(at(pod, "/containers/0/securityContext/capabilities/drop/0"), "ALL");
    }
}
