//! A Slurm of one node with two processors, started from Debian's packages on this machine for the time of the test.

use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use ltsc_core::eval::Overrides;
use ltsc_core::files::VPath;
use ltsc_core::pipeline::{self, Options};
use ltsc_evaluation::chunk::{Chunks, Plan, Store};
use ltsc_evaluation::executor::slurm::Slurm;
use ltsc_evaluation::executor::{Local, News, Outcome};
use ltsc_evaluation::job::{Job, Runner};
use ltsc_render::image::read;
use ltsc_render::run::driver;

use super::super::{Disk, Sources, python, root, skip};
use super::{Stage, hasty, kill, letters, run, taken_over, until};

/// What Debian installs, beside `scancel` and others.
const DAEMONS: [&str; 3] = ["munged", "slurmctld", "slurmd"];

/// A Slurm, which ends with this.
struct Cluster {
    folder: tempfile::TempDir,
}

fn program(name: &str) -> Option<PathBuf> {
    ["/usr/sbin", "/usr/bin", "/sbin", "/bin"]
        .map(|folder| Path::new(folder).join(name))
        .into_iter()
        .find(|path| path.is_file())
}

fn said(command: &mut Command) -> Option<String> {
    let out = command.output().ok()?;
    out.status.success().then(|| String::from_utf8_lossy(&out.stdout).trim().to_owned())
}

impl Cluster {
    /// Starts one; none where its programs are not installed, or this is not root.
    fn start() -> Option<Self> {
        let here = DAEMONS.iter().chain(&["sbatch", "squeue", "scancel"]).all(|name| program(name).is_some());
        if !here || said(Command::new("id").arg("-u"))? != "0" {
            return None;
        }
        let folder = tempfile::Builder::new().prefix("ltsc-slurm-").tempdir().expect("a folder");
        let place = folder.path().display();
        for name in ["state", "spool"] {
            fs::create_dir(folder.path().join(name)).expect("a folder");
        }
        let key: Vec<u8> = (0..64).flat_map(|_| format!("{:?}", Instant::now()).into_bytes()).take(1024).collect();
        fs::write(folder.path().join("key"), key).expect("a key");
        let modes = [("key", 0o600), ("", 0o755)];
        for (name, mode) in modes {
            let rights = std::os::unix::fs::PermissionsExt::from_mode(mode);
            fs::set_permissions(folder.path().join(name), rights).expect("rights");
        }
        let listeners = [0; 2].map(|_| TcpListener::bind("127.0.0.1:0").expect("a port"));
        let [control, node] = listeners.map(|one| one.local_addr().expect("a port").port());
        let host = said(&mut Command::new("hostname")).expect("a name");
        let text = format!(
            "ClusterName=test\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={control}\nSlurmdPort={node}\nSlurmUser=root\n\
             AuthType=auth/munge\nAuthInfo=socket={place}/munge.socket\nProctrackType=proctrack/pgid\nTaskPlugin=task/none\n\
             SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\nReturnToService=2\nMpiDefault=none\nSchedulerParameters=batch_sched_delay=0,sched_interval=1\n\
             StateSaveLocation={place}/state\nSlurmdSpoolDir={place}/spool\nSlurmctldPidFile={place}/slurmctld.pid\n\
             SlurmdPidFile={place}/slurmd.pid\nSlurmctldLogFile={place}/slurmctld.log\nSlurmdLogFile={place}/slurmd.log\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs=2\nPartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n"
        );
        fs::write(folder.path().join("slurm.conf"), text).expect("written");
        let cluster = Self { folder };
        let munge = [
            ("key-file", "key"),
            ("socket", "munge.socket"),
            ("pid-file", "munged.pid"),
            ("log-file", "munged.log"),
            ("seed-file", "seed"),
        ];
        let words =
            munge.map(|(option, name)| format!("--{option}={place}/{name}", place = cluster.folder.path().display()));
        cluster.daemon("munged", &[&words[..], &["-f".to_owned()]].concat());
        let config = ["-f".to_owned(), cluster.folder.path().join("slurm.conf").display().to_string()];
        cluster.daemon("slurmctld", &config);
        cluster.daemon("slurmd", &config);
        until("the node is there", || {
            cluster.client("sinfo", &["--noheader", "--format=%T"]).as_deref() == Some("idle")
        });
        Some(cluster)
    }

    fn daemon(&self, name: &str, words: &[String]) {
        let mut command = Command::new(program(name).expect("a daemon"));
        let out =
            command.args(words).env("SLURM_CONF", self.folder.path().join("slurm.conf")).output().expect("started");
        assert!(out.status.success(), "{name}: {}", String::from_utf8_lossy(&out.stderr));
    }

    fn client(&self, name: &str, words: &[&str]) -> Option<String> {
        let mut command = Command::new(program(name).expect("a client"));
        said(command.args(words).env("SLURM_CONF", self.folder.path().join("slurm.conf")))
    }

    /// A stage whose programs of Slurm talk to this cluster.
    fn stage(&self) -> Stage {
        let stage = Stage::new();
        for name in ["sbatch", "squeue", "scancel", "sacct"] {
            let config = self.folder.path().join("slurm.conf");
            let real = program(name).expect("a client");
            stage.program(
                &format!("bin/{name}"),
                &format!("SLURM_CONF='{}' exec {} \"$@\"\n", config.display(), real.display()),
            );
        }
        stage
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for name in DAEMONS.iter().rev() {
            let pid = fs::read_to_string(self.folder.path().join(format!("{name}.pid"))).unwrap_or_default();
            let there = || Path::new("/proc").join(pid.trim()).is_dir() && !pid.trim().is_empty();
            if there() {
                let _asked = Command::new("kill").arg(pid.trim()).status();
                let start = Instant::now();
                while there() && start.elapsed() < Duration::from_secs(10) {
                    std::thread::sleep(Duration::from_millis(20));
                }
            }
        }
    }
}

/// The parent of a process.
fn parent(pid: &str) -> String {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).expect("a process");
    status.lines().find_map(|line| line.strip_prefix("PPid:")).expect("a parent").trim().to_owned()
}

/// One after the other: starting a cluster takes some seconds.
#[test]
#[ignore = "long: starts a cluster"]
fn a_cluster_renders_what_this_machine_renders_and_survives_what_is_killed() {
    let Some(cluster) = Cluster::start() else {
        return skip("slurm", "`apt-get install slurmctld slurmd slurm-client munge`, and to be root");
    };
    ended_from_outside(&cluster);
    always_failing(&cluster);
    taken_over(&cluster.stage(), 2);
    the_same_pixels(&cluster);
    the_same_evaluation(&cluster);
}

/// One element is cancelled, and the ltsc of another one is killed: both are submitted again.
fn ended_from_outside(cluster: &Cluster) {
    let stage = cluster.stage();
    stage.touch("hold");
    std::thread::scope(|scope| {
        let enders = scope.spawn(|| {
            until("two tasks run", || stage.renders() == 2);
            let list = cluster
                .client("squeue", &["--noheader", "--array", "--states=RUNNING", "--format=%F_%K/%j.%K"])
                .expect("a list");
            let running: Vec<(&str, &str)> = list.lines().filter_map(|line| line.split_once('/')).collect();
            assert_eq!(running.len(), 2, "{list}");
            cluster.client("scancel", &[running[0].0]).expect("cancelled");
            // The renderer's parent is its supervisor, whose parent is the task.
            let pid = fs::read_to_string(stage.at("renders").join(running[1].1)).expect("a process");
            let supervisor = parent(pid.trim());
            kill(&parent(&supervisor));
            until("the renderer of a killed task ends", || !Path::new("/proc").join(pid.trim()).is_dir());
            stage.touch("go");
        });
        let (done, said) = stage.run(&stage.slurm(), &[0, 1, 2, 3], false);
        enders.join().expect("ended");
        assert_eq!(letters(&done.expect("outcomes")), "mmmm", "{said:?}");
        let again: Vec<&String> = said.iter().filter(|text| text.contains("submitted again")).collect();
        assert_eq!(again.len(), 2, "{said:?}");
        assert!(
            again.iter().any(|text| text.contains("CANCELLED")) && again.iter().any(|text| text.contains("FAILED")),
            "{said:?}"
        );
    });
    stage.is_tidy();
}

fn always_failing(cluster: &Cluster) {
    let stage = cluster.stage();
    stage.touch("broken");
    let (done, said) = stage.run(&stage.slurm(), &[0, 1], true);
    let done = done.expect("outcomes");
    let messages: Vec<&String> = done
        .iter()
        .filter_map(|outcome| if let Outcome::Failed(failure) = outcome { Some(&failure.message) } else { None })
        .collect();
    assert!(!messages.is_empty() && !letters(&done).contains(['m', 'k']), "{done:?}");
    assert!(messages.iter().all(|message| message.contains("there is no light")), "{messages:?}");
    assert!(said.iter().filter(|text| text.contains("has array")).count() <= 3, "{said:?}");
    stage.is_tidy();
}

/// Pixels of this machine and of the cluster, and their mean; a task that is lost in between changes nothing.
fn the_same_pixels(cluster: &Cluster) {
    let Some(python) = python("mitsuba-3") else {
        return skip("slurm with a renderer", "`ltsc renderers install mitsuba-3`");
    };
    let stage = cluster.stage();
    let path = VPath::resolve("", "scenes-src/cbox_classic.lts").expect("a path");
    let overrides = Overrides { width: Some(16), height: Some(16), ..Overrides::default() };
    let options = Options { overrides, ..Options::default() };
    let checked = pipeline::check(&Disk(root().to_owned()), &mut Sources::default(), &path, &options);
    let (scene, _) = pipeline::prepare(checked.scene.expect("a scene")).expect("a valid scene");
    let found = Runner::find(driver("mitsuba-3").expect("a driver"), Some(&python), None, None);
    let runner = Runner { threads: Some(1), ..found.expect("a renderer") };
    let job = Job::new(&scene, &runner).expect("a job");
    let here = Store::at(stage.at("here"));
    let there = stage.store();
    let seeds = [0, 1, 2];
    let (done, _) = run(&Local::new(stage.resources()), &here, &job, &seeds, false, &|_| {});
    assert_eq!(letters(&done.expect("outcomes")), "mmm");
    let program = PathBuf::from(env!("CARGO_BIN_EXE_ltsc"));
    let slurm = hasty(Slurm::new(&stage.resources(), &stage.env(), program).expect("a cluster"));
    let ended = std::sync::atomic::AtomicBool::new(false);
    let end_first = |news: &News<'_>| {
        if matches!(news, News::Begun(_)) && !ended.swap(true, std::sync::atomic::Ordering::SeqCst) {
            let list = cluster
                .client("squeue", &["--noheader", "--array", "--states=RUNNING", "--format=%F_%K"])
                .expect("a list");
            cluster.client("scancel", &[list.lines().next().expect("a task")]).expect("cancelled");
        }
    };
    let (done, said) = run(&slurm, &there, &job, &seeds, false, &end_first);
    assert_eq!(letters(&done.expect("outcomes")), "mmm", "{said:?}");
    assert!(said.iter().any(|text| text.contains("submitted again")), "{said:?}");
    for seed in seeds {
        let [one, other] = [&here, &there].map(|store| read(&store.path(&job.identity(), 2, seed)).expect("a chunk"));
        assert!(one.0 == other.0, "seed {seed}");
        let value = |name: &str| {
            [&one.1, &other.1].map(|all| all.iter().find(|(key, _)| key == name).map(|(_, value)| value.clone()))
        };
        for name in one
            .1
            .iter()
            .map(|(name, _)| name.as_str())
            .filter(|name| name.contains("hash") || name.contains("renderer"))
        {
            assert_eq!(value(name)[0], value(name)[1], "{name}");
        }
    }
    let combined = |store: &Store| {
        let plan = Plan { samples: 2, count: 3 };
        Chunks::of(store, &job, plan, 0).and_then(|chunks| chunks.combined()).expect("a mean")
    };
    assert!(combined(&here) == combined(&there));
    stage.is_tidy();
}

/// An evaluation on this machine and on the cluster, where a task is ended from outside: equal bytes.
fn the_same_evaluation(cluster: &Cluster) {
    let Some(python) = python("mitsuba-3") else {
        return skip("an evaluation on slurm", "`ltsc renderers install mitsuba-3`");
    };
    let stage = cluster.stage();
    let text = format!(
        "scenes = [\"{}\"]\nsettings = {{ samples = 16, size = [16, 16] }}\n[renderers.m]\ntarget = \"mitsuba-3\"\npath = \"{}\"\n\
         threads = 1\n[[case]]\nname = \"a\"\nrenderer = \"m\"\n[[case]]\nname = \"b\"\nrenderer = \"m\"\nsettings = {{ seed = 50 }}\n",
        root().join("scenes-src/cbox_classic.lts").display(),
        python.display()
    );
    fs::write(stage.at("study.toml"), text).expect("an evaluation");
    let path = std::env::join_paths(
        std::iter::once(stage.at("bin")).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    );
    let path = path.expect("a path");
    let eval = |words: &[&str]| {
        let mut command = super::super::ltsc();
        command.current_dir(stage.at("")).env("PATH", &path).env("LTSC_CACHE", stage.at("cache"));
        command.env("LTSC_TRUST", stage.at("")).args(["eval", "study.toml"]).args(words);
        super::super::run(&mut command)
    };
    let here = eval(&["-o", "here"]);
    assert!(matches!(here.code, Some(0 | 1)), "{}{}", here.out, here.err);
    let shared = stage.at("shared").display().to_string();
    let there = std::thread::scope(|scope| {
        let running = || cluster.client("squeue", &["--noheader", "--array", "--states=RUNNING", "--format=%F_%K"]);
        let ender = scope.spawn(move || {
            until("a task runs", || running().is_some_and(|list| !list.is_empty()));
            let list = running().unwrap_or_default();
            list.lines().next().and_then(|task| cluster.client("scancel", &[task]))
        });
        let ran = eval(&["-o", "there", "--executor", "slurm", "--shared", &shared, "--option=--partition=all"]);
        ender.join().expect("ended");
        ran
    });
    assert_eq!(there.code, here.code, "{}{}", there.out, there.err);
    assert_eq!(there.out, here.out);
    for name in ["results.json", "comparisons.csv", "scenes/cbox_classic/a.exr", "scenes/cbox_classic/b.exr"] {
        let [one, other] = ["here", "there"].map(|folder| fs::read(stage.at(folder).join(name)).expect("a file"));
        assert!(one == other, "{name}");
    }
    stage.is_tidy();
}
