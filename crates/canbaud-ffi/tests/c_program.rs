//! The C test program, compiled with all warnings and run with sanitizers and under valgrind where
//! they are to be had. `scripts/firmware` runs the same program on Cortex-M.

use std::path::{Path, PathBuf};
use std::process::Command;

const FLAGS: [&str; 7] =
    ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror", "-Iinclude"];

/// Runs a command in the crate's directory: whether it succeeded, and what it said.
fn run(program: &str, args: &[&str]) -> Option<(bool, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(program).args(args).current_dir(root).output().ok()?;
    let said = [output.stdout, output.stderr].concat();
    Some((output.status.success(), String::from_utf8_lossy(&said).into_owned()))
}

/// The directory with the static library, which cargo makes anew if need be.
fn library() -> PathBuf {
    let program = std::env::current_exe().expect("this program");
    let profile = program.parent().and_then(Path::parent).expect("target/PROFILE");
    let target = profile.parent().expect("target").display().to_string();
    let args = ["build", "--quiet", "-p", "canbaud-ffi", "--target-dir", &target];
    let (ok, said) = run(env!("CARGO"), &args).expect("cargo runs");
    assert!(ok, "{said}");
    PathBuf::from(target).join("debug/libcanbaud_ffi.a")
}

/// Compiles the program with `more` flags; `None` if the compiler cannot.
fn compile(name: &str, more: &[&str]) -> Option<PathBuf> {
    let library = library();
    let program = library.with_file_name(name);
    let (library, path) = (library.display().to_string(), program.display().to_string());
    let files = ["c/test.c", "c/host.c", &library, "-o", &path, "-lpthread", "-ldl", "-lm"];
    let (ok, said) = run("cc", &[&FLAGS[..], more, &files].concat())?;
    if !ok && !more.is_empty() && said.contains("cannot find") {
        return None;
    }
    assert!(ok, "{said}");
    Some(program)
}

fn holds(program: &str, args: &[&str]) {
    let (ok, said) = run(program, args).expect("it runs");
    assert!(ok && said.contains("the C API holds"), "{said}");
}

#[test]
fn c_program_holds() {
    if run("cc", &["--version"]).is_none() {
        eprintln!("there is no C compiler: the C program was not compiled");
        return;
    }
    let plain = compile("canbaud-c-test", &[]).expect("a program").display().to_string();
    holds(&plain, &[]);
    match compile("canbaud-c-test-sanitized", &["-g", "-fsanitize=address,undefined"]) {
        Some(program) => holds(&program.display().to_string(), &[]),
        None => eprintln!("there are no sanitizers: the C program ran without"),
    }
    if run("valgrind", &["--version"]).is_some_and(|(ok, _)| ok) {
        holds("valgrind", &["--quiet", "--error-exitcode=9", &plain]);
    } else {
        eprintln!("there is no valgrind: the C program ran without");
    }
}

#[test]
fn c_examples_compile() {
    for example in ["c/examples/bare_metal.c", "c/examples/rtos.c"] {
        let args = [&FLAGS[..], &["-fsyntax-only", example]].concat();
        let Some((ok, said)) = run("cc", &args) else {
            eprintln!("there is no C compiler: the examples were not compiled");
            return;
        };
        assert!(ok, "{said}");
    }
}

/// What `README.md` tells: installed into a prefix, found by pkg-config, linked both ways.
#[test]
fn installed_library_links_shared_and_static() {
    if !["cc", "pkg-config"].iter().all(|program| run(program, &["--version"]).is_some()) {
        eprintln!("there is no C compiler or no pkg-config: the installation was not tried");
        return;
    }
    let target = library().parent().and_then(Path::parent).expect("target").to_path_buf();
    let prefix = target.join("ffi-prefix");
    let _ = std::fs::remove_dir_all(&prefix);
    let script = format!(
        "set -e
         export CARGO_TARGET_DIR={target} CANBAUD_PROFILE=dev
         ./install {prefix}
         export PKG_CONFIG_PATH={prefix}/lib/pkgconfig
         cd {prefix}
         here={here}
         [ \"$(pkg-config --modversion canbaud)\" = {version} ]
         flags=\"{flags}\"
         cc $flags $(pkg-config --cflags canbaud) $here/c/test.c $here/c/host.c \\
             $(pkg-config --libs canbaud) -o shared
         cc $flags $(pkg-config --cflags canbaud) $here/c/test.c $here/c/host.c \\
             -Wl,-Bstatic $(pkg-config --libs canbaud) -Wl,-Bdynamic \\
             $(pkg-config --static --libs-only-l canbaud | sed s/-lcanbaud_ffi//) -o static
         LD_LIBRARY_PATH={prefix}/lib ./shared
         rm lib/libcanbaud_ffi.so
         ./static",
        target = target.display(),
        prefix = prefix.display(),
        here = env!("CARGO_MANIFEST_DIR"),
        version = env!("CARGO_PKG_VERSION"),
        flags = FLAGS[..6].join(" "),
    );
    let (ok, said) = run("bash", &["-c", &script]).expect("bash runs");
    assert!(ok && said.matches("the C API holds").count() == 2, "{said}");
}
