"""Blender's entry to the extension. Nothing is imported before Blender asks for it."""


def register():
    from . import addon

    addon.register()


def unregister():
    from . import addon

    addon.unregister()
