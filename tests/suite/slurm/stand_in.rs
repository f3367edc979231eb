//! Programs that stand in for Slurm's: what goes wrong there is told here.

use std::fs;
use std::path::PathBuf;

use ltsc_evaluation::chunk::Store;
use ltsc_evaluation::executor::News;
use ltsc_evaluation::executor::slurm::{Slurm, clean};
use ltsc_evaluation::failure::Exit;
use ltsc_render::env::Env;

use super::super::{ltsc, run};
use super::{Stage, hasty, letters, taken_over, until};
use ltsc_evaluation::executor::{Outcome, Resources};

/// Each task is a file `tasks/NAME.ARRAY.INDEX` with its state. `lose` has lines `INDEX STATE` of tasks that the next array loses: they
/// get this state and are not begun; `GONE` is no state at all. `refuse` has the words of a refusal.
const SBATCH: &str = r#"
echo "$*" >> sbatch.log
if [ -f refuse ]; then cat refuse >&2; exit 1; fi
for word; do
    case $word in --job-name=*) name=${word#*=};; --array=*) array=${word#*=};; --chdir=*) folder=${word#*=};; esac
    script=$word
done
here=$PWD
id=$(($(wc -l < sbatch.log) + 16))
last=${array#0-}; last=${last%%%*}
if [ -f lose ]; then mv lose losing; fi
for index in $(seq 0 "$last"); do
    task=$here/tasks/$name.$id.$index
    state=$(sed -n "s/^$index //p" losing 2> /dev/null)
    if [ "$state" = GONE ]; then continue; fi
    if [ -n "$state" ]; then echo "$state" > "$task"; continue; fi
    echo PENDING > "$task"
    (
        cd "$folder" || exit
        SLURM_JOB_NAME=$name SLURM_ARRAY_TASK_ID=$index SLURM_CPUS_ON_NODE=1 sh "$script" &
        echo $! > "$here/pids.new.$index.$id"; mv "$here/pids.new.$index.$id" "$here/pids/$name.$id.$index"
        echo RUNNING > "$task"
        if wait $!; then end=COMPLETED; else end=FAILED; fi
        if [ "$(cat "$task")" = RUNNING ]; then echo $end > "$task"; fi
    ) < /dev/null > "$folder/$name-$index.log" 2>&1 &
done
rm -f losing
echo "$id;cluster"
"#;

const SQUEUE: &str = r#"
if [ -f silent ]; then echo 'slurm_load_jobs error: Unable to contact slurm controller (connect failure)' >&2; exit 1; fi
for word; do case $word in --name=*) names=${word#*=};; esac; done
for name in $(echo "$names" | tr , ' '); do
    for task in tasks/"$name".*; do
        if [ ! -f "$task" ]; then continue; fi
        rest=${task#tasks/"$name".}
        echo "$name/${rest%.*}/${rest#*.}/$(cat "$task")/None"
    done
done
"#;

const SCANCEL: &str = r#"
echo "$*" >> scancel.log
for word; do
    case $word in --name=*) pattern="${word#*=}.*";; *) pattern="*.${word%_*}.${word#*_}";; esac
    for task in tasks/$pattern; do
        if [ ! -f "$task" ]; then continue; fi
        case $(cat "$task") in PENDING | RUNNING) echo CANCELLED > "$task"; kill "$(cat "pids/${task#tasks/}")" ;; esac
    done
done
exit 0
"#;

fn stage() -> Stage {
    let stage = Stage::new();
    for name in ["tasks", "pids"] {
        fs::create_dir(stage.at(name)).expect("a folder");
    }
    for (name, body) in [("sbatch", SBATCH), ("squeue", SQUEUE), ("scancel", SCANCEL)] {
        stage.program(&format!("bin/{name}"), body);
    }
    stage
}

impl Stage {
    fn log(&self, name: &str) -> Vec<String> {
        let text = fs::read_to_string(self.at(name)).unwrap_or_default();
        text.lines().map(str::to_owned).collect()
    }
}

#[test]
fn chunks_are_rendered_by_one_array_and_kept() {
    let stage = stage();
    let (done, said) = stage.run(&stage.slurm(), &[3, 4, 5], false);
    assert_eq!(letters(&done.expect("outcomes")), "mmm", "{said:?}");
    assert_eq!(said, ["Slurm has array 17: chunks 3, at most 2 at once"]);
    let submitted = stage.log("sbatch.log");
    assert_eq!(submitted.len(), 1);
    for word in ["--partition=all ", "--array=0-2%2 ", "--cpus-per-task=1 ", "--parsable "] {
        assert!(submitted[0].contains(word), "{submitted:?}");
    }
    assert_eq!(stage.renders(), 3);
    stage.is_tidy();
    // What is there is not asked for again.
    let (done, _) = stage.run(&stage.slurm(), &[2, 3, 4], false);
    assert_eq!(letters(&done.expect("outcomes")), "mkk");
    assert!(stage.log("sbatch.log")[1].contains("--array=0-0%2 "));
    assert!(stage.log("scancel.log").is_empty());
}

#[test]
fn what_is_missing_is_told() {
    let stage = stage();
    let program = PathBuf::from(env!("CARGO_BIN_EXE_ltsc"));
    let refused = |resources: &Resources, env: &Env| {
        let failure = Slurm::new(resources, env, program.clone()).err().expect("refused");
        (failure.exit, failure.message)
    };
    let nowhere = Env::of(&[("PATH", "/nowhere")]);
    let (exit, message) = refused(&stage.resources(), &nowhere);
    assert_eq!((exit, message.as_str()), (Exit::Environment, "Slurm is not here: there is no `sbatch` on the path"));
    let (exit, message) = refused(&Resources { shared: None, ..stage.resources() }, &stage.env());
    assert!(exit == Exit::Usage && message.contains("needs a folder that all machines share"), "{message}");
    let missing = Resources { shared: Some(stage.at("shraed")), ..stage.resources() };
    let (exit, message) = refused(&missing, &stage.env());
    assert!(exit == Exit::Usage && message.ends_with("shraed: there is no such folder"), "{message}");
    let option = Resources { options: vec!["short".to_owned()], ..stage.resources() };
    assert_eq!(refused(&option, &stage.env()), (Exit::Usage, "`short` is no option of `sbatch`".to_owned()));
    // Chunks that other machines do not see, and a folder in which nothing can be made.
    let outside = Stage { path: stage.path.clone(), _folder: None };
    fs::write(stage.at("shared/jobs"), "").expect("written");
    let (done, _) = outside.run(&stage.slurm(), &[1], false);
    let failure = done.expect_err("it cannot be written");
    assert!(failure.message.starts_with(&stage.at("shared").display().to_string()), "{}", failure.message);
    let mut files = ltsc_core::files::MemoryFiles::default();
    files.insert("one.lts", super::MINIMAL.replace("NAME", "one"));
    let runner = stage.runner();
    let job = ltsc_evaluation::job::Job::new(&super::prepared(&files, "one.lts"), &runner).expect("a job");
    let elsewhere = Store::at(stage.at("chunks"));
    let (done, _) = super::run(&stage.slurm(), &elsewhere, &job, &[1], false, &|_| {});
    let failure = done.expect_err("not seen");
    assert!(
        failure.exit == Exit::Usage && failure.message.contains("not seen by other machines"),
        "{}",
        failure.message
    );
    assert!(stage.log("sbatch.log").is_empty());
}

#[test]
fn a_refusal_is_told_in_the_words_of_sbatch() {
    let stage = stage();
    let words = "sbatch: error: invalid partition specified: all\nsbatch: error: Batch job submission failed: Invalid \
                 partition name specified\n";
    fs::write(stage.at("refuse"), words).expect("written");
    let (done, _) = stage.run(&stage.slurm(), &[1, 2], true);
    let failure = done.expect_err("refused");
    assert_eq!(
        (failure.exit, failure.message.as_str()),
        (
            Exit::Environment,
            "`sbatch` refuses the work: invalid partition specified: all; Batch job submission failed: Invalid partition name \
             specified"
        )
    );
    stage.is_tidy();
}

#[test]
fn lost_tasks_are_submitted_again() {
    let stage = stage();
    fs::write(stage.at("lose"), "0 PREEMPTED\n2 GONE\n3 NODE_FAIL\n").expect("written");
    stage.program("bin/sacct", "echo \"$*\" >> sacct.log; echo 'CANCELLED by 1000'\n");
    let (done, said) = stage.run(&stage.slurm(), &[0, 1, 2, 3], false);
    assert_eq!(letters(&done.expect("outcomes")), "mmmm", "{said:?}");
    for (seed, word) in [(0, "PREEMPTED"), (2, "CANCELLED"), (3, "NODE_FAIL")] {
        let note = format!("a chunk is submitted again: one by pbrt-r4, seed {seed} (Slurm says {word})");
        assert!(said.contains(&note), "{said:?}");
    }
    assert!(stage.log("sacct.log")[0].contains("--jobs=17_2"));
    assert_eq!(stage.renders(), 4);
    stage.is_tidy();
}

#[test]
fn a_refusal_after_something_was_taken_is_waited_for() {
    let stage = stage();
    fs::write(stage.at("lose"), "0 PREEMPTED\n").expect("written");
    let heard = |news: &News<'_>| match news {
        News::Note(text) if text.contains("has array 17") => {
            fs::write(stage.at("refuse"), "sbatch: error: Socket timed out on send/recv operation\n").expect("written");
        }
        News::Note(text)
            if text == "`sbatch` refuses the work: Socket timed out on send/recv operation: tried again" =>
        {
            fs::remove_file(stage.at("refuse")).expect("removed");
        }
        _ => {}
    };
    let (done, said) = stage.run_with(&stage.slurm(), &[0, 1], false, &heard);
    assert_eq!(letters(&done.expect("outcomes")), "mm", "{said:?}");
    assert_eq!(stage.log("sbatch.log").len(), 3, "{said:?}");
    stage.is_tidy();
}

#[test]
fn a_task_that_is_lost_again_and_again_is_given_up() {
    let stage = stage();
    let again = |news: &News<'_>| {
        if matches!(news, News::Note(_)) {
            fs::write(stage.at("lose"), "0 NODE_FAIL\n").expect("written");
        }
    };
    fs::write(stage.at("lose"), "0 NODE_FAIL\n").expect("written");
    let (done, _) = stage.run_with(&stage.slurm(), &[0], false, &again);
    let done = done.expect("outcomes");
    let Outcome::Failed(failure) = &done[0] else { panic!("{done:?}") };
    assert_eq!(failure.message, "the task of one by pbrt-r4, seed 0 was lost: Slurm says NODE_FAIL");
    assert!(failure.help.as_ref().is_some_and(|help| help.contains("the same folder on all machines")));
    assert_eq!(stage.log("sbatch.log").len(), 3);
    stage.is_tidy();
}

#[test]
fn a_renderer_that_always_fails_is_given_up_with_its_log() {
    for (keep_going, seeds, least) in [(false, &[0][..], "f"), (true, &[0], "f"), (false, &[0, 1, 2, 3, 4], "s")] {
        let stage = stage();
        stage.touch("broken");
        let (done, said) = stage.run(&stage.slurm(), seeds, keep_going);
        let done = done.expect("outcomes");
        let failed =
            done.iter().find_map(|outcome| if let Outcome::Failed(failure) = outcome { Some(failure) } else { None });
        let failure = failed.unwrap_or_else(|| panic!("{done:?}"));
        assert!(
            failure.exit == Exit::Environment && failure.message.contains("there is no light"),
            "{}",
            failure.message
        );
        assert!(letters(&done).contains(least) && !letters(&done).contains(['m', 'k']), "{done:?} {said:?}");
        let tries: usize = stage.log("sbatch.log").len();
        assert!(tries <= 3, "{tries}");
        stage.is_tidy();
    }
}

#[test]
fn what_a_node_lacks_is_told() {
    let stage = stage();
    let slurm = Slurm::new(&stage.resources(), &stage.env(), stage.at("ltsc")).expect("a cluster");
    let (done, _) = stage.run(&hasty(slurm), &[0], false);
    let done = done.expect("outcomes");
    let Outcome::Failed(failure) = &done[0] else { panic!("{done:?}") };
    assert!(
        failure.message.contains("Slurm says FAILED") && failure.message.contains("there is no "),
        "{}",
        failure.message
    );
    // The renderer is another one by the time a task asks for it.
    let other = |news: &News<'_>| {
        if matches!(news, News::Note(_)) {
            fs::write(stage.at("version"), "pbrt-r4 4.5.3\n").expect("written");
        }
    };
    fs::write(stage.at("lose"), "0 NODE_FAIL\n").expect("written");
    let (done, _) = stage.run_with(&stage.slurm(), &[0], false, &other);
    let done = done.expect("outcomes");
    let Outcome::Failed(failure) = &done[0] else { panic!("{done:?}") };
    assert!(failure.message.ends_with("is pbrt-r4 4.5.3 here, not 4.5.2"), "{}", failure.message);
    fs::write(stage.at("version"), "pbrt-r4 4.5.2\n").expect("written");
    let remove = |news: &News<'_>| {
        if matches!(news, News::Note(_)) {
            let _gone = fs::remove_file(stage.at("pbrt-r4"));
        }
    };
    fs::write(stage.at("lose"), "0 NODE_FAIL\n").expect("written");
    let (done, _) = stage.run_with(&stage.slurm(), &[0], false, &remove);
    let done = done.expect("outcomes");
    let Outcome::Failed(failure) = &done[0] else { panic!("{done:?}") };
    assert!(failure.message.contains("no working `pbrt-r4` was found"), "{}", failure.message);
    assert!(failure.help.as_ref().is_some_and(|help| help.contains("the same place")), "{:?}", failure.help);
}

#[test]
fn silence_is_waited_for() {
    let stage = stage();
    let wake = |news: &News<'_>| match news {
        News::Note(text) if text.contains("has array") => stage.touch("silent"),
        News::Note(text) if text.contains("Unable to contact slurm controller") => {
            fs::remove_file(stage.at("silent")).expect("removed");
        }
        _ => {}
    };
    let (done, said) = stage.run_with(&stage.slurm(), &[0], false, &wake);
    assert_eq!(letters(&done.expect("outcomes")), "m");
    assert!(said.iter().any(|text| text.starts_with("Slurm gives no answer, and is asked again")), "{said:?}");
}

#[test]
fn a_signal_cancels_the_array() {
    let stage = stage();
    stage.touch("hold");
    let mut child = stage.process();
    until("all tasks run", || stage.renders() == 3);
    stage.touch("signal");
    assert_eq!(child.wait().expect("ended").code(), Some(143));
    let states: Vec<String> = fs::read_dir(stage.at("tasks"))
        .expect("tasks")
        .map(|task| fs::read_to_string(task.expect("an entry").path()).expect("a state"))
        .collect();
    assert_eq!(states, ["CANCELLED\n"; 3]);
    stage.is_tidy();
}

#[test]
fn a_killed_run_is_taken_over() {
    let stage = stage();
    taken_over(&stage, 3);
    assert_eq!(stage.log("sbatch.log").len(), 2);
    assert_eq!(stage.log("scancel.log"), ["17_2"]);
}

#[test]
fn a_killed_run_that_nobody_goes_on_with_is_cancelled() {
    for by_cleaning in [true, false] {
        let stage = stage();
        stage.touch("hold");
        let mut child = stage.process();
        until("all tasks run", || stage.renders() == 3);
        assert_eq!(clean(&stage.at("shared"), &stage.env()).expect("cleaned"), 0, "it is alive");
        child.kill().expect("killed");
        child.wait().expect("ended");
        if by_cleaning {
            let path = std::env::join_paths([stage.at("bin"), "/usr/bin".into(), "/bin".into()]).expect("a path");
            let mut prune = ltsc();
            prune.args(["cache", "prune", "--days", "1", "--shared"]).arg(stage.at("shared")).env("PATH", path);
            let ran = run(&mut prune);
            let line = "killed runs that are removed with what they had submitted: 1";
            assert!(ran.code == Some(0) && ran.err.contains(line), "{}", ran.err);
        } else {
            // The next run wants something else.
            stage.touch("go");
            fs::remove_file(stage.at("hold")).expect("removed");
            let (done, _) = stage.run(&stage.slurm(), &[9], false);
            assert_eq!(letters(&done.expect("outcomes")), "m");
        }
        assert_eq!(stage.log("scancel.log").len(), 1, "{:?}", stage.log("scancel.log"));
        stage.is_tidy();
    }
}
