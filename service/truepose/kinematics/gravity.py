"""Gravity torques about the joint axes, and their regressors where the masses are unknown.

For joint i with axis z_i through o_i and the masses m_j at c_j that its frame or one beyond it carries,

    tau_i = z_i . sum_j m_j (c_j - o_i) x g

Sign: the torque that the weight exerts about the z axis of the joint, so that a gearbox of compliance c turns
by +c * torque. Level 3 of the model; the thesis takes the torques at the undeflected arm, here they are taken
wherever the chain that is handed in stands (docs/decisions/0003).

References
----------
A. Nubiola, PhD thesis, ETS Montreal, 2014, annex I, equation (I.10).
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import LinkMass
from truepose.kinematics.chain import Chain
from truepose.kinematics.frames import cross, rotate


def gravity_torques(chain: Chain, masses: tuple[LinkMass, ...], gravity_m_s2: FloatArray) -> FloatArray:
    """Torques of the weight of all links beyond each joint.

    Parameters
    ----------
    chain : Chain
        n configurations, J joints.
    masses : tuple of LinkMass
        Frames 1..J; those of the flange frame are the tool's.
    gravity_m_s2 : ndarray, shape (3,)
        In the world frame [m/s2]; kg m/s2 times mm is N mm.

    Returns
    -------
    ndarray, shape (n, J)
        Torques [N mm].
    """
    # Written out instead of an einsum: runs over contiguous rows, and is asked for in every balance of
    # torques.
    product = chain.z * gravity_moments(chain, masses, gravity_m_s2)
    return np.asarray((product[..., 0] + product[..., 1] + product[..., 2]).T)


def gravity_moments(chain: Chain, masses: tuple[LinkMass, ...], gravity_m_s2: FloatArray) -> FloatArray:
    """Moments of the weight of all links beyond each joint about the origin of its frame.

    Parameters as of `gravity_torques`.

    Returns
    -------
    ndarray, shape (J, n, 3)
        In the world frame [N mm].
    """
    joints, n, _ = chain.z.shape
    arms = np.empty((joints, 3, n))
    # One sweep from the tip: what a joint carries is what the next one carries and its own frame's masses.
    # Kept as mass and first moment about the world's origin, it is moved to each joint's origin by one
    # subtraction.
    mass_kg, first = 0.0, np.zeros((n, 3))  # of the links beyond the joint [kg, kg mm], from the tip inwards
    for joint in reversed(range(joints)):
        for link in masses:
            if link.frame - 1 == joint:
                centre = chain.origin[joint] + rotate(
                    chain.rotation[joint], np.array(link.centre_of_gravity_mm)
                )
                mass_kg, first = mass_kg + link.mass_kg, first + link.mass_kg * centre
        np.subtract(first.T, mass_kg * chain.origin[joint].T, out=arms[joint])
    return cross(np.swapaxes(arms, 1, 2), gravity_m_s2)


def centre_of_gravity(chain: Chain, link: LinkMass) -> FloatArray:
    """Return where the weight of a link acts in the world.

    Parameters
    ----------
    chain : Chain
        n configurations.
    link : LinkMass

    Returns
    -------
    ndarray, shape (n, 3)
        [mm]
    """
    joint = link.frame - 1
    arm = rotate(chain.rotation[joint], np.array(link.centre_of_gravity_mm))
    return np.asarray(chain.origin[joint] + arm)


def moment_regressor(
    chain: Chain, joint: int, frame: int, component: int, gravity_m_s2: FloatArray
) -> FloatArray:
    """Torque about a joint per first moment of mass of a frame: z_i . (e_k x g), e_k an axis of the frame.

    Only the two components across each joint axis are needed: the mass and the component along the
    axis regroup into the frames before it.

    Parameters
    ----------
    chain : Chain
    joint, frame : int
        0-based, frame >= joint.
    component : int
        0 for x, 1 for y of the frame.
    gravity_m_s2 : ndarray, shape (3,)

    Returns
    -------
    ndarray, shape (n,)
        Torque per moment [N mm per kg mm].

    References
    ----------
    M. Gautier, W. Khalil, IEEE Trans. Robotics and Automation 6(3), 1990, 368-373.
    """
    turning = cross(chain.rotation[frame, :, :, component], gravity_m_s2)
    torque: FloatArray = np.einsum("ni,ni->n", chain.z[joint], turning)
    return torque
