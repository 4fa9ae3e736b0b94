"""Ringdown in Blender. `register` imports the parts that need a running Blender."""


def register():
    from . import registration

    registration.register()


def unregister():
    from . import registration

    registration.unregister()
