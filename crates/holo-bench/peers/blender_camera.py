"""What the scripts that drive Blender have in common: the off-axis camera, and the denoiser."""
from mathutils import Vector


def second_camera(scene):
    """A copy of the scene's camera, from which it is rendered from now on."""
    camera = scene.camera.copy()
    camera.data = scene.camera.data.copy()
    scene.collection.objects.link(camera)
    scene.camera = camera
    return camera


def place(camera, base, x_m, y_m, focus_m):
    """Places an off-axis camera: translated parallel to the sensor, with the lens shift that aligns the focus plane."""
    camera.location = base.matrix_world.translation + base.matrix_world.to_3x3() @ Vector((x_m, y_m, 0))
    shift = base.data.lens / base.data.sensor_width / focus_m
    camera.data.shift_x, camera.data.shift_y = -x_m * shift, -y_m * shift


def denoise(scene, method):
    """"off", or "oidn": OpenImageDenoise at its best, with albedo and normals."""
    cycles = scene.cycles
    cycles.use_denoising = method == "oidn"
    if cycles.use_denoising:
        cycles.denoiser, cycles.denoising_quality = "OPENIMAGEDENOISE", "HIGH"
        cycles.denoising_input_passes, cycles.denoising_prefilter = "RGB_ALBEDO_NORMAL", "ACCURATE"
