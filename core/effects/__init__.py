"""Every effect that the loop can name. One file each; to add one, add it to a tuple below."""

from . import (
    air_drag,
    asymmetric_stiffness,
    contact,
    dry_friction,
    large_amplitude,
    perspective,
    relaxation,
    rolling_shutter,
    split_modes,
    steady_drive,
    stiffness_drift,
)

TIME_EFFECTS = (
    relaxation.EFFECT,
    dry_friction.EFFECT,
    air_drag.EFFECT,
    large_amplitude.EFFECT,
    asymmetric_stiffness.EFFECT,
    contact.ABOVE,
    contact.BELOW,
    stiffness_drift.EFFECT,
    steady_drive.EFFECT,
    split_modes.EFFECT,
    rolling_shutter.EFFECT,
    perspective.EFFECT,
)
