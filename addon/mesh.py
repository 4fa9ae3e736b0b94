"""A surface as an object of the scene."""

import bpy

from ..core.data import Surface


def new_object(context, name: str, surface: Surface) -> bpy.types.Object:
    """The surface (m) as an object at the origin, in the scene's units."""
    settings = context.scene.unit_settings
    metre = settings.scale_length if settings.system != "NONE" else 1.0
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata((surface.vertices / metre).tolist(), [], surface.faces.tolist())
    obj = bpy.data.objects.new(name, mesh)
    context.scene.collection.objects.link(obj)
    context.view_layer.update()
    return obj
