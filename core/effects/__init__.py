"""Every effect that the loop can name. One file each; to add one, add it to a tuple below."""

from . import (
    added_mass,
    air_drag,
    aliasing,
    asymmetric_stiffness,
    clock,
    compliant_pin,
    contact,
    dry_friction,
    graded_stiffness,
    gravity_preload,
    large_amplitude,
    mesh_stiffening,
    perspective,
    poisson_ratio,
    relaxation,
    rolling_shutter,
    split_modes,
    steady_drive,
    stiffness_drift,
    structural_damping,
    viscous_damping,
)

TIME_EFFECTS = (
    relaxation.EFFECT,
    dry_friction.EFFECT,
    air_drag.EFFECT,
    large_amplitude.EFFECT,
    large_amplitude.OVERALL,
    asymmetric_stiffness.EFFECT,
    contact.ABOVE,
    contact.BELOW,
    stiffness_drift.EFFECT,
    steady_drive.EFFECT,
    split_modes.EFFECT,
    rolling_shutter.EFFECT,
    perspective.EFFECT,
)

MODAL_EFFECTS = (
    added_mass.EFFECT,
    compliant_pin.EFFECT,
    graded_stiffness.EFFECT,
    poisson_ratio.EFFECT,
    gravity_preload.EFFECT,
    clock.EFFECT,
)

DAMPING = {law.EFFECT.name: law for law in (structural_damping, viscous_damping)}

COMPUTED_EFFECTS = (aliasing.EFFECT, mesh_stiffening.EFFECT)

BY_NAME = {
    effect.name: effect
    for effect in (
        *TIME_EFFECTS,
        *MODAL_EFFECTS,
        *COMPUTED_EFFECTS,
        *(law.EFFECT for law in DAMPING.values()),
    )
}
