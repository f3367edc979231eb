# Renders a Mitsuba 3 scene. The job has main, samples, passes (the most there may be), first_seed and
# seed_step (of the passes), threads (or null), variant, scratch.


def split(samples, passes, box):
    """Passes small enough to show progress. Only a box filter weights every sample alike, so
    that passes can be averaged without a bias; other filters get long passes."""
    size = max(4 if box else 64, -(-samples // passes))
    while samples > 0:
        yield min(size, samples)
        samples -= size


def main(job):
    import drjit
    import mitsuba as mi

    emit("version", version=mi.__version__)
    mi.set_variant(job["variant"])
    start = time.monotonic()
    scene = mi.load_file(job["main"])
    emit("loaded", seconds=time.monotonic() - start)
    # Not before: with one thread Mitsuba waits for ever for an OpenEXR texture (3.9.1).
    if job["threads"]:
        drjit.set_thread_count(job["threads"])
    sensor = scene.sensors()[0]
    box = sensor.film().rfilter().is_box_filter()
    start = time.monotonic()
    done = 0
    for index, size in enumerate(split(job["samples"], job["passes"], box)):
        seed = job["first_seed"] + index * job["seed_step"]
        image = mi.render(scene, sensor=sensor, spp=size, seed=seed)
        channels = image.shape[2]
        if channels not in (1, 3):
            image = image[:, :, : (3 if channels > 3 else 1)]
        # Stratified samplers round the number up.
        size = sensor.sampler().sample_count()
        name = "pass-%d.pfm" % index
        mi.Bitmap(image).write(os.path.join(job["scratch"], name))
        done += size
        emit("pass", samples=size, done=done, total=max(done, job["samples"]), file=name,
             seconds=time.monotonic() - start)
    emit("done", seconds=time.monotonic() - start)


run(main)
