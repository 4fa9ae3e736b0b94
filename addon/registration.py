"""What Blender is told of us, and takes back."""


def register():
    pass


def unregister():
    pass
