# Renders a scene for Cycles, which is a Python file that builds it in Blender. The job has main, samples, seed, threads (or
# null), scratch. The file runs under another name than `__main__`, so that it only builds.

import re
import runpy


def main(job):
    import bpy

    emit("version", version=bpy.app.version_string.split()[0])
    start = time.monotonic()
    runpy.run_path(job["main"], run_name="scene")
    scene = bpy.context.scene
    scene.cycles.samples = job["samples"]
    scene.cycles.seed = job["seed"]
    if job["threads"]:
        scene.render.threads_mode = "FIXED"
        scene.render.threads = job["threads"]
    else:
        scene.render.threads_mode = "AUTO"
    path = os.path.join(job["scratch"], "image.exr")
    scene.render.filepath = path
    scene.render.use_file_extension = False
    emit("loaded", seconds=time.monotonic() - start)
    start = time.monotonic()
    shown = 0.0

    def progress(*arguments):
        # "... | Sample 17/64"
        nonlocal shown
        found = re.search(r"Sample (\d+)/(\d+)", " ".join(map(str, arguments)))
        now = time.monotonic()
        if found and now - shown >= 0.25:
            shown = now
            emit("progress", done=int(found[1]), total=int(found[2]), seconds=now - start)

    bpy.app.handlers.render_stats.append(progress)
    bpy.ops.render.render(write_still=True)
    seconds = time.monotonic() - start
    emit("pass", samples=job["samples"], done=job["samples"], total=job["samples"], file="image.exr", seconds=seconds)
    emit("done", seconds=seconds)


run(main)
