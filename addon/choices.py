"""What can be chosen in the panel: (identifier, name, tooltip)."""

VIEWS = (
    ("FRONT", "Front", "The camera looks along +Y"),
    ("BACK", "Back", "The camera looks along -Y"),
    ("RIGHT", "Right", "The camera looks along -X"),
    ("LEFT", "Left", "The camera looks along +X"),
    ("TOP", "Top", "The camera looks down"),
)
SOURCES = (
    ("CSV", "Table", "A table of positions over time: NAME.x,y,z in metres or NAME.u,v in pixels"),
    ("CLIP", "Tracks", "The tracks of a movie clip, followed with Blender's own tracker"),
    ("VIDEO", "Video", "A movie clip: Ringdown follows the points where its tracks begin"),
)
SCALES = (
    ("POINTS", "Points", "From the placed points themselves: their distances on the mesh"),
    ("LENGTH", "Known Length", "From one length in the picture"),
    ("CAMERA", "Scene Camera", "As the scene's camera sees the object"),
)
