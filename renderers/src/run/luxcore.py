# Renders a LuxCore scene. The job has main, samples, seed, threads (or null), scratch. The working
# directory is the folder of the scene, because LuxCore resolves names against it.

import array


def write_pfm(path, width, height, pixels):
    """Both LuxCore and the format begin with the bottom row, so nothing is flipped here."""
    if sys.byteorder != "little":
        pixels.byteswap()
    with open(path, "wb") as out:
        out.write(b"PF\n%d %d\n-1.0\n" % (width, height))
        pixels.tofile(out)


def main(job):
    import pyluxcore

    emit("version", version=pyluxcore.Version())
    # Init takes a log handler, but a Python one aborts the interpreter at its end (2.11.2).
    pyluxcore.Init()
    start = time.monotonic()
    properties = pyluxcore.Properties(job["main"])
    properties.Set(pyluxcore.Property("batch.haltspp", [job["samples"]]))
    # 0 gives the same image as 1 (2.11.2), so the first seed is 1.
    properties.Set(pyluxcore.Property("renderengine.seed", [job["seed"] + 1]))
    if job["threads"]:
        properties.Set(pyluxcore.Property("native.threads.count", [job["threads"]]))
    config = pyluxcore.RenderConfig(properties)
    session = pyluxcore.RenderSession(config)
    session.Start()
    emit("loaded", seconds=time.monotonic() - start)
    start = time.monotonic()
    shown = 0.0
    while not session.HasDone():
        time.sleep(0.02)
        session.UpdateStats()
        now = time.monotonic()
        if now - shown >= 0.25:
            shown = now
            done = session.GetStats().Get("stats.renderengine.pass").GetInt()
            emit("progress", done=done, total=job["samples"], seconds=now - start)
    session.Stop()
    seconds = time.monotonic() - start
    session.UpdateStats()
    done = session.GetStats().Get("stats.renderengine.pass").GetInt()
    film = session.GetFilm()
    width, height = film.GetWidth(), film.GetHeight()
    pixels = array.array("f", bytes(4 * 3 * width * height))
    film.GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels, 0)
    write_pfm(os.path.join(job["scratch"], "image.pfm"), width, height, pixels)
    emit("pass", samples=done, done=done, total=max(done, job["samples"]), file="image.pfm",
         seconds=seconds)
    emit("done", seconds=seconds)


run(main)
