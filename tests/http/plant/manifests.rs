//! Names in `deploy/` and its documents exist: settings, metrics, alerts, fields of manifests.

use std::{collections::BTreeSet, fs, path::Path, process::Command};

use flankfit::config::{Networks, parse_networks};
use serde_json::Value;

use super::yaml;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Every manifest.
fn manifests() -> Vec<Value> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("deploy/kubernetes");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.flat_map(|file| yaml::documents(&fs::read_to_string(file).unwrap())).collect()
}

/// The only one of its kind.
fn manifest(kind: &str) -> Value {
    let mut found: Vec<Value> = manifests().into_iter().filter(|manifest| manifest["kind"] == kind).collect();
    assert_eq!(found.len(), 1, "{kind}");
    found.remove(0)
}

#[track_caller]
fn at<'a>(value: &'a Value, pointer: &str) -> &'a Value {
    value.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is missing in {value}"))
}

#[track_caller]
fn number(value: &Value, pointer: &str) -> u64 {
    at(value, pointer).as_u64().unwrap_or_else(|| panic!("{pointer} is no number in {value}"))
}

fn words(text: &str, is_part: impl Fn(char) -> bool) -> BTreeSet<&str> {
    text.split(|c: char| !is_part(c)).filter(|word| !word.is_empty()).collect()
}

/// Flags and variables listed by `flankfit COMMAND --help`.
fn settings(command: &str) -> BTreeSet<String> {
    let help = Command::new(env!("CARGO_BIN_EXE_flankfit")).args([command, "--help"]).output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    words(&help, |c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_')).into_iter().map(str::to_owned).collect()
}

fn is_flag(word: &&str) -> bool {
    word.strip_prefix("--").is_some_and(|name| name.starts_with(|c: char| c.is_ascii_lowercase()))
}

#[test]
fn every_setting_that_is_named_exists() {
    let there = settings("serve");
    let mut named = 0;
    for path in [
        "docs/how-to/plant.md",
        "docs/how-to/runbook.md",
        "docs/how-to/scale.md",
        "deploy/README.md",
        "deploy/haproxy.cfg",
        "deploy/kubernetes/deployment.yaml",
        "deploy/kubernetes/migration.yaml",
    ] {
        let text = read(path);
        let variables = words(&text, |c| c.is_ascii_alphanumeric() || c == '_');
        let variables = variables.into_iter().filter(|word| word.starts_with("FLANKFIT_"));
        // in documents flags of other programs are in commands, ours alone as code
        let ours = |line: &&str| path.ends_with(".cfg") || line.contains("flankfit serve");
        let mut flags: Vec<&str> =
            text.lines().filter(ours).flat_map(|line| line.split([' ', '.', ',', ':'])).collect();
        flags.extend(text.split('`').filter(|code| !code.contains(char::is_whitespace)));
        for word in variables.chain(flags.into_iter().filter(is_flag)) {
            named += 1;
            assert!(there.contains(word), "{path} names {word}");
        }
    }
    assert!(named > 30, "only {named} were found");
}

#[test]
fn metrics_of_alerts_exist_and_alerts_are_in_the_runbook() {
    let telemetry = read("src/telemetry.rs");
    let runbook = read("docs/how-to/runbook.md");
    let rules = yaml::documents(&read("deploy/alerts.yaml")).remove(0);
    let mut alerts = Vec::new();
    for rule in at(&rules, "/groups/0/rules").as_array().unwrap() {
        let name = at(rule, "/alert").as_str().unwrap();
        alerts.push(name);
        let expression = at(rule, "/expr").as_str().unwrap();
        let mut metrics = words(expression, |c| c.is_ascii_alphanumeric() || c == '_');
        metrics.retain(|word| word.starts_with("flankfit_"));
        for metric in &metrics {
            // a histogram is three
            let base = ["_bucket", "_count", "_sum"].iter().find_map(|end| metric.strip_suffix(end));
            let is_there = |metric: &str| telemetry.contains(&format!("\"{metric}\""));
            assert!(is_there(metric) || base.is_some_and(is_there), "{name} names {metric}");
        }
        assert!(!metrics.is_empty() || expression.contains("up{job=\"flankfit\"}"), "{name}: {expression}");
        assert!(at(rule, "/for").as_str().unwrap().ends_with(['s', 'm', 'h']), "{name}");
        assert!(["info", "warning", "critical"].contains(&at(rule, "/labels/severity").as_str().unwrap()), "{name}");
        assert!(at(rule, "/annotations/summary").is_string(), "{name}");
    }
    let described: Vec<&str> = runbook.lines().filter_map(|line| line.strip_prefix("### ")).collect();
    assert_eq!(alerts, described);
}

/// The value of a setting in a container.
#[track_caller]
fn set(container: &Value, name: &str) -> u64 {
    let all = container["env"].as_array().unwrap();
    let entry = all.iter().find(|entry| entry["name"] == name).unwrap_or_else(|| panic!("{name} is not set"));
    entry["value"].as_str().unwrap().parse().unwrap()
}

#[test]
fn servers_are_renewed_without_a_gap() {
    let deployment = manifest("Deployment");
    assert_eq!(number(&deployment, "/spec/strategy/rollingUpdate/maxUnavailable"), 0);
    let pod = at(&deployment, "/spec/template/spec");
    let container = at(pod, "/containers/0");
    let grace = set(container, "FLANKFIT_DRAIN_DELAY") + set(container, "FLANKFIT_SHUTDOWN_GRACE") + 5;
    assert!(number(pod, "/terminationGracePeriodSeconds") >= grace);
    let probe = at(container, "/readinessProbe");
    assert_eq!(at(probe, "/httpGet/path"), "/readyz");
    let seen = number(probe, "/periodSeconds") * number(probe, "/failureThreshold") + number(probe, "/timeoutSeconds");
    assert!(seen < set(container, "FLANKFIT_DRAIN_DELAY"), "it is seen to end before it does");
    assert_eq!(at(container, "/livenessProbe/httpGet/path"), "/healthz");
    assert_eq!(number(&manifest("PodDisruptionBudget"), "/spec/minAvailable"), 2);
    for pod in [pod, at(&manifest("Job"), "/spec/template/spec")] {
        assert_eq!(at(pod, "/securityContext/runAsNonRoot"), true);
        assert_eq!(at(pod, "/containers/0/securityContext/readOnlyRootFilesystem"), true);
        assert_eq!(at(pod, "/containers/0/securityContext/capabilities/drop/0"), "ALL");
        assert!(at(pod, "/containers/0/resources/limits/memory").is_string());
    }
}

#[test]
fn all_servers_fit_the_database() {
    let (deployment, scaling) = (manifest("Deployment"), manifest("HorizontalPodAutoscaler"));
    let container = at(&deployment, "/spec/template/spec/containers/0");
    // with 4 connections for long reads, and one each for LISTEN and NOTIFY
    let each = set(container, "FLANKFIT_STORE_WRITERS") + set(container, "FLANKFIT_DATABASE_READERS") + 4 + 2;
    let surge = number(&deployment, "/spec/strategy/rollingUpdate/maxSurge");
    let connections = (number(&scaling, "/spec/maxReplicas") + surge) * each;
    let most = at(&scaling, "/metadata/annotations/flankfit~1max-connections").as_str().unwrap();
    assert!(connections <= most.parse::<u64>().unwrap() - 10);
    assert!(read("deploy/README.md").contains(&format!("must allow {most} connections")));
    // of two that say how many there are, the one would take back what the other did
    assert_eq!(at(&deployment, "/spec").get("replicas"), None);
    assert_eq!(number(&scaling, "/spec/minReplicas"), 3);
    assert_eq!(number(&scaling, "/spec/metrics/0/resource/target/averageUtilization"), 70);
    assert_eq!(at(&scaling, "/spec/scaleTargetRef/name"), at(&deployment, "/metadata/name"));
}

#[test]
fn manifests_name_each_other_and_their_ports() {
    let deployment = manifest("Deployment");
    let labels = at(&deployment, "/spec/template/metadata/labels");
    let container = at(&deployment, "/spec/template/spec/containers/0");
    for (kind, version, selector) in [
        ("Deployment", "apps/v1", "/spec/selector/matchLabels"),
        ("Service", "v1", "/spec/selector"),
        ("PodDisruptionBudget", "policy/v1", "/spec/selector/matchLabels"),
        ("NetworkPolicy", "networking.k8s.io/v1", "/spec/podSelector/matchLabels"),
    ] {
        let manifest = manifest(kind);
        assert_eq!((at(&manifest, "/apiVersion"), at(&manifest, selector)), (&Value::from(version), labels), "{kind}");
    }
    let service = manifest("Service");
    let network = manifest("NetworkPolicy");
    let [http, ops] = [0, 1].map(|index| at(container, &format!("/ports/{index}")));
    assert_eq!((&http["name"], &ops["name"]), (&Value::from("http"), &Value::from("ops")));
    assert_eq!(at(&service, "/spec/ports/0/targetPort"), "http");
    for (index, port) in [http, ops].into_iter().enumerate() {
        assert_eq!(at(&network, &format!("/spec/ingress/{index}/ports/0/port")), &port["containerPort"]);
    }
    // the migration is no server: requests must not go there
    let job = manifest("Job");
    assert_ne!(at(&job, "/spec/template/metadata/labels"), labels);
    assert_eq!(at(&job, "/spec/template/spec/containers/0/args/0"), "migrate");
    assert_eq!(at(&job, "/spec/template/spec/containers/0/image"), at(container, "/image"));
    assert!(settings("migrate").contains("FLANKFIT_DATABASE_URL_FILE"));
    // a Job is not changed by another apply
    let name = at(&job, "/metadata/name").as_str().unwrap();
    let readme = read("deploy/README.md");
    let [gone, made, ended] = [
        format!("delete job {name} --ignore-not-found\n"),
        "apply -f deploy/kubernetes/migration.yaml\n".to_owned(),
        format!("wait --for=condition=complete job/{name}\n"),
    ]
    .map(|command| readme.find(&command).unwrap_or_else(|| panic!("{command}")));
    assert!(gone < made && made < ended);
    // clients are distinguished
    let all = at(container, "/env").as_array().unwrap();
    let proxies = all.iter().find(|entry| entry["name"] == "FLANKFIT_TRUSTED_PROXIES").unwrap();
    let proxies = parse_networks(at(proxies, "/value").as_str().unwrap()).unwrap();
    assert_ne!(proxies, Networks::default());
    for text in ["kubernetes/deployment.yaml", "kubernetes/migration.yaml"] {
        assert!(read(&format!("deploy/{text}")).contains("Untried"), "{text}");
    }
}

/// No secret is in the environment: each file that it names is there.
#[test]
fn secrets_are_mounted_as_files() {
    // a variable of the image and a file are two places
    let image = read("Dockerfile");
    assert!(image.contains("WORKDIR /data") && !image.contains("FLANKFIT_DATABASE_URL"));
    for (kind, count) in [("Deployment", 2), ("Job", 1)] {
        let manifest = manifest(kind);
        let pod = at(&manifest, "/spec/template/spec");
        let container = at(pod, "/containers/0");
        let folder = at(container, "/volumeMounts/0/mountPath").as_str().unwrap();
        assert_eq!(at(container, "/volumeMounts/0/name"), at(pod, "/volumes/0/name"));
        let secret = at(pod, "/volumes/0/secret/secretName").as_str().unwrap();
        // read by the group that the files are given
        assert_eq!(
            (number(pod, "/volumes/0/secret/defaultMode"), number(pod, "/securityContext/fsGroup")),
            (0o440, 65532)
        );
        let readme = read("deploy/README.md");
        let (_, made) = readme.split_once(&format!("generic {secret} ")).unwrap();
        let made = made.split("kubectl").next().unwrap();
        let variables = at(container, "/env").as_array().unwrap();
        let mut named = 0;
        for variable in variables {
            assert!(variable.get("valueFrom").is_none(), "{variable}");
            let Some(name) = at(variable, "/name").as_str().unwrap().strip_suffix("_FILE") else { continue };
            let file = at(variable, "/value").as_str().unwrap().strip_prefix(folder).unwrap();
            assert!(made.contains(&format!("--from-literal={}=", file.trim_start_matches('/'))), "{name}");
            named += 1;
        }
        assert_eq!(named, count, "{kind}");
    }
}

/// Prometheus' own program reads the rules, and holds each against series that fire it and that do
/// not.
#[test]
#[cfg_attr(without_promtool, ignore = "promtool is not installed (Debian: prometheus)")]
fn each_alert_fires_when_it_should() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("deploy");
    for arguments in [["check", "rules", "alerts.yaml"], ["test", "rules", "alerts.test.yaml"]] {
        let output = Command::new("promtool").args(arguments).current_dir(&folder).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && said.contains("SUCCESS"), "{said}");
    }
}

/// Each alert has series that fire it.
#[test]
fn each_alert_is_tried() {
    let rules = read("deploy/alerts.yaml");
    let tests = yaml::documents(&read("deploy/alerts.test.yaml")).remove(0);
    let fired: BTreeSet<&str> = at(&tests, "/tests")
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|test| at(test, "/alert_rule_test").as_array().unwrap())
        .filter(|tried| at(tried, "/exp_alerts").as_array().is_some_and(|alerts| !alerts.is_empty()))
        .map(|tried| at(tried, "/alertname").as_str().unwrap())
        .collect();
    let alerts: BTreeSet<&str> = rules.lines().filter_map(|line| line.trim().strip_prefix("- alert: ")).collect();
    // unknown servers do not count
    let without_targets = at(&tests, "/tests").as_array().unwrap().iter().filter(|test| {
        !at(test, "/input_series").to_string().contains("flankfit")
            && at(test, "/alert_rule_test").to_string().contains("exp_labels")
    });
    let without_targets: Vec<&Value> = without_targets.map(|test| at(test, "/alert_rule_test/1/alertname")).collect();
    assert_eq!(without_targets, ["FlankfitNoSpare"]);
    assert!(alerts.len() > 10);
    assert_eq!(fired, alerts);
}
