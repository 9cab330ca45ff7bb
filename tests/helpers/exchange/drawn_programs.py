"""Programs of drawn targets, and which joints their controllers take to them by rules written anew.

What a controller takes is found from the bytes of the file by `other_controller` and by the rules below,
which know neither the readers nor the rules of the product.
"""

import re
from dataclasses import dataclass

import numpy as np

from tests.helpers.exchange import other_controller as other
from tests.helpers.identification.models import model_of, parameters_of
from truepose.exchange.programs.corrected import corrected_program
from truepose.exchange.programs.formats import read_program
from truepose.exchange.programs.understood import Understood
from truepose.exchange.robots.shipped import load_robot
from truepose.kinematics.inverse import branch_of

NEAR = np.radians(0.3)
_NUMBER = r"(-?[0-9.]+(?:[eE][-+]?[0-9]+)?)"
_NONE = "9E9,9E9,9E9,9E9,9E9,9E9"


def erring_model(robot, seed, size=1.0):
    """A robot that is off by some tenths of a degree and millimetres, softly sprung."""
    rng = np.random.default_rng(seed)
    kinds = (("alpha", 1.5e-3, "rad"), ("a", 0.4, "mm"), ("theta", 3e-3, "rad"), ("d", 0.4, "mm"))
    names = [(f"{kind}_{row}", width, unit) for row in range(2, 7) for kind, width, unit in kinds]
    geometry = [(name, size * width * rng.standard_normal(), unit) for name, width, unit in names]
    parameters = parameters_of("geometry", geometry)
    return model_of(robot, *parameters)


def drawn_joints(robot, n, seed, *, hard=True):
    """Joints over the whole range; if hard, half of them at singularities, borders of turns and limits."""
    rng = np.random.default_rng(seed)
    limits = robot.joint_limits
    low, high = (
        np.array([-2.9, -1.8, -1.8, -3.1, -2.0, -3.1] if limits is None else [r.lower_rad for r in limits]),
        np.array([2.9, 1.8, 1.8, 3.1, 2.0, 3.1] if limits is None else [r.upper_rad for r in limits]),
    )
    low, high = np.maximum(low, -np.pi), np.minimum(high, np.pi)
    joints = rng.uniform(low, high, (n, 6))
    kind = rng.integers(0, 10, n) if hard else np.full(n, 9)
    joints[kind == 0, 4] = rng.uniform(-0.06, 0.06, (kind == 0).sum())  # the wrist stretched
    joints[kind == 1, 2] = _stretched(robot) + rng.uniform(-0.06, 0.06, (kind == 1).sum())
    axis = rng.choice([0, 3, 5], n)
    border = np.clip(rng.choice([-np.pi, -np.pi / 2, 0.0, np.pi / 2, np.pi], n), low[axis], high[axis])
    some = np.isin(kind, (2, 3))
    joints[some, axis[some]] = (border + rng.uniform(-NEAR, NEAR, n))[some]
    at = np.where(rng.random((n, 6)) < 0.5, low, high)
    joints[kind == 4] = np.where(rng.random((n, 6)) < 0.3, at, joints)[kind == 4]
    over = _over_axis_1(robot, joints)
    joints[kind == 5] = over[kind == 5]
    return np.clip(joints, low, high)


def _stretched(robot):
    """Joint 3 at which forearm and upper arm are one line."""
    angles = np.linspace(-np.pi, np.pi, 3601)
    joints = np.zeros((len(angles), 6))
    joints[:, 2] = angles
    frames = [other.transform(robot, joints, 0, k)[:, :3, 3] for k in (2, 4)]
    return angles[np.argmax(np.linalg.norm(frames[1] - frames[0], axis=1))]


def _over_axis_1(robot, joints):
    """The same with joint 2 so that the wrist is nearest to axis 1, within some millimetres."""
    best = joints.copy()
    away = np.full(len(joints), np.inf)
    for angle in np.linspace(-np.pi, np.pi, 181):
        tried = joints.copy()
        tried[:, 1] = angle
        now = np.linalg.norm(other.transform(robot, tried, 0, 4)[:, :2, 3], axis=1)
        best[now < away], away = tried[now < away], np.minimum(now, away)
    return best


@dataclass
class Language:
    """How targets are written, and what the controller takes to what stands there."""

    robot: str
    name: str
    write: object
    taken: object


@dataclass
class Counted:
    """What became of drawn targets."""

    drawn: int
    corrected: int
    elsewhere: int  # corrected ones to which the controller takes other joints than were solved
    alone: dict


def tried(language, n, seed, size=1.0, *, hard=True):
    """Draw targets, have them corrected, and let another controller run the corrected file."""
    robot = load_robot(language.robot)
    model, joints = erring_model(robot, seed, size), drawn_joints(robot, n, seed, hard=hard)
    branch = branch_of(robot, joints)
    count = Counted(len(joints), 0, 0, {})
    for number in range(8):
        own = joints[branch == number]
        if not len(own):
            continue
        data = language.write(robot, own)
        program = read_program(data, language.name, angles="zyx")
        answer = corrected_program(model, program, Understood(branch=number))
        places = [int(re.search(r"[0-9]+", name[1:])[0]) for name in answer.names]
        solved = np.flatnonzero(answer.found.solved)
        rows = np.array([places[row] for row in solved], dtype=int)
        sent = answer.found.joints_rad[solved]
        taken = language.taken(robot, answer.data, own)[rows]
        off = np.abs(taken - sent).max(axis=1, initial=0.0)
        count.corrected += len(rows)
        count.elsewhere += int((~(off <= np.radians(0.03))).sum())
        for left in answer.left_alone:
            count.alone[left.reason.key] = count.alone.get(left.reason.key, 0) + 1
        for status in answer.found.status[~answer.found.solved]:
            count.alone[str(status)] = count.alone.get(str(status), 0) + 1
    return count


def numbers(text):
    return [float(number) for number in re.findall(_NUMBER, text)]


def _pose(x, rotation):
    found = np.tile(np.eye(4), (len(x), 1, 1))
    found[:, :3, :3], found[:, :3, 3] = rotation, x
    return found


def _in_posture(robot, pose, joints):
    """Of all answers those in the posture of the drawn joints, in (-pi, pi]."""
    answers, wanted = other.spherical_answers(robot, pose), other.posture(robot, joints)
    found = np.full((len(pose), 6), np.nan)
    for k in range(8):
        with np.errstate(invalid="ignore"):
            same = (other.posture(robot, answers[:, k]) == wanted).all(axis=1)
        same &= np.isfinite(answers[:, k]).all(axis=1)
        found[same] = answers[same, k]
    return found


# ABB -------------------------------------------------------------------------------------------------------
def _rapid(robot, joints):
    pose, quadrant = other.transform(robot, joints), np.floor(joints / other.QUARTER).astype(int)
    cfx = other.posture(robot, joints) @ [4, 2, 1]
    lines = []
    for k, (one, quarter) in enumerate(zip(pose, quadrant, strict=True)):
        x = ",".join(f"{v:.6f}" for v in one[:3, 3])
        q = ",".join(f"{v:.10f}" for v in quaternion(one[:3, :3]))
        conf = f"{quarter[0]},{quarter[3]},{quarter[5]},{cfx[k]}"
        lines.append(f"  CONST robtarget p{k}:=[[{x}],[{q}],[{conf}],[{_NONE}]];")
    moves = [f"    MoveJ p{k},v100,fine,tool0;" for k in range(len(joints))]
    body = "\n".join([*lines, "  PROC main()", *moves, "  ENDPROC"])
    return f"MODULE M\n{body}\nENDMODULE\n".encode()


def _taken_by_abb(robot, data, drawn):
    found = re.findall(rb"robtarget p[0-9]+:=\[\[([^\]]*)\],\[([^\]]*)\],\[([^\]]*)\]", data)
    read = [np.array([numbers(group[k].decode()) for group in found]) for k in range(3)]
    answers = other.spherical_answers(robot, _pose(read[0], from_quaternion(read[1])))
    conf = read[2].astype(int)
    bits = np.stack([conf[:, 3] >> 2 & 1, conf[:, 3] >> 1 & 1, conf[:, 3] & 1], axis=1).astype(bool)
    taken = np.full((len(conf), 6), np.nan)
    for k in range(8):
        right = (other.posture(robot, np.nan_to_num(answers[:, k])) == bits).all(axis=1)
        right &= np.isfinite(answers[:, k]).all(axis=1)
        taken[right] = answers[right, k]
    taken = _within_limits(robot, taken)
    for axis, place in ((0, 0), (3, 1), (5, 2)):  # exactly the quarter that is named
        turn = np.floor(taken[:, axis] / other.QUARTER)
        whole = (conf[:, place] - turn) / 4
        taken[:, axis] += other.FULL * np.where(whole == np.round(whole), whole, np.nan)
    return taken


# KUKA ------------------------------------------------------------------------------------------------------
def _krl(robot, joints):
    pose, turn = other.transform(robot, joints), (joints < 0) @ (1 << np.arange(6))
    lines = []
    for k, one in enumerate(pose):
        a, b, c = zyx(one[:3, :3])
        x = "X {:.6f},Y {:.6f},Z {:.6f}".format(*one[:3, 3])
        bits = f"{turn[k]}" if k % 2 else f"'B{turn[k]:06b}'"
        lines.append(f"DECL E6POS XP{k}={{{x},A {a:.9f},B {b:.9f},C {c:.9f},S 2,T {bits},E1 0.0}}")
    moves = [f"PTP XP{k}" for k in range(len(joints))]
    head = "DEF M( )\n$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}\n$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}"
    return "\n".join([head, *lines, *moves, "END", ""]).encode()


def _taken_by_kuka(robot, data, drawn):
    found = re.findall(
        rb"E6POS XP[0-9]+=\{X (.*?),Y (.*?),Z (.*?),A (.*?),B (.*?),C (.*?),S 2,T (.*?),E1", data
    )
    read = np.array([[float(v) for v in group[:6]] for group in found])
    turn = [int(g[6][2:-1], 2) if g[6].startswith(b"'B") else int(g[6]) for g in found]
    taken = _within_limits(robot, _in_posture(robot, _pose(read[:, :3], from_zyx(read[:, 3:])), drawn))
    negative = (np.array(turn)[:, None] >> np.arange(6) & 1).astype(bool)
    wrong = (taken < 0) != negative
    return taken + np.where(wrong, np.where(negative, -other.FULL, other.FULL), 0.0)


# FANUC -----------------------------------------------------------------------------------------------------
def _fanuc(robot, joints):
    blocks, moves = [], []
    for k, one in enumerate(other.transform(robot, joints)):
        r, p, w = zyx(one[:3, :3])
        x, y, z = one[:3, 3]
        blocks.append(
            f"P[{k}]{{\n   GP1:\n\tUF : 0, UT : 0,\tCONFIG : 'N U T, 0, 0, 0',\n"
            f"\tX = {x:.3f} mm,\tY = {y:.3f} mm,\tZ = {z:.3f} mm,\n"
            f"\tW = {w:.3f} deg,\tP = {p:.3f} deg,\tR = {r:.3f} deg\n}};"
        )
        moves.append(f"   {k + 1}:J P[{k}] 20% FINE ;")
    return "\n".join(["/PROG M", "/MN", *moves, "/POS", *blocks, "/END", ""]).encode()


def _taken_by_fanuc(robot, data, drawn):
    entry = rb"X = (.*?) mm,\tY = (.*?) mm,\tZ = (.*?) mm,\n\tW = (.*?) deg,\tP = (.*?) deg,\tR = (.*?) deg"
    read = np.array([[float(v) for v in group] for group in re.findall(entry, data)])
    assert data.count(b"'N U T, 0, 0, 0'") == len(read)
    pose = _pose(read[:, :3], from_zyx(read[:, [5, 4, 3]]))
    return _in_posture(robot, pose, drawn)  # no turns: every joint within 180 degrees


# Universal Robots ------------------------------------------------------------------------------------------
def _script(robot, joints):
    lines, moves = ["def m():", "  set_tcp(p[0,0,0,0,0,0])"], []
    for k, one in enumerate(other.transform(robot, joints)):
        place = ",".join(f"{v:.12f}" for v in [*one[:3, 3] / 1000, *vector(one[:3, :3])])
        near = ",".join(f"{v:.12f}" for v in joints[k])
        lines += [f"  p{k}=p[{place}]", f"  n{k}=[{near}]"]
        moves.append(f"  movej(get_inverse_kin(p{k}, qnear=n{k}), a=1, v=1)")
    return "\n".join([*lines, *moves, "end", ""]).encode()


def _taken_by_ur(robot, data, drawn):
    read = np.array([numbers(text.decode()) for text in re.findall(rb" p[0-9]+=p\[(.*?)\]", data)])
    near = np.array([numbers(text.decode()) for text in re.findall(rb" n[0-9]+=\[(.*?)\]", data)])
    taken = []
    for first in range(0, len(read), 200):
        part = slice(first, first + 200)
        pose = _pose(1000 * read[part, :3], from_vector(read[part, 3:]))
        every = other.turned_to(other.searched_answers(robot, pose, near[part]), near[part, None])
        apart = np.nan_to_num(((every - near[part, None]) ** 2).sum(axis=2), nan=np.inf)
        taken.append(every[np.arange(len(every)), apart.argmin(axis=1)])
    return np.concatenate(taken)


def _within_limits(robot, joints):
    """Axes whose range is not even about zero, such as axis 2 of a KUKA, in the turn that is in it."""
    middle = np.array([(r.lower_rad + r.upper_rad) / 2 for r in robot.joint_limits])
    return joints - other.FULL * np.round((joints - middle) / other.FULL)


LANGUAGES = {
    "RAPID": Language("abb-irb-120", "m.mod", _rapid, _taken_by_abb),
    "KRL": Language("kuka-kr-6-r900-sixx", "m.src", _krl, _taken_by_kuka),
    "FANUC LS": Language("fanuc-lr-mate-200ic", "m.ls", _fanuc, _taken_by_fanuc),
    "URScript": Language("universal-robots-ur10", "m.script", _script, _taken_by_ur),
}


# Rotations -------------------------------------------------------------------------------------------------
def vector(matrix):
    """Axis times angle."""
    w, *v = quaternion(matrix)
    size = np.linalg.norm(v)
    return np.array(v) * (2 * np.arctan2(size, w) / size if size else 2.0)


def from_vector(v):
    angle = np.linalg.norm(v, axis=1, keepdims=True)
    half = np.where(angle > 0, np.sin(angle / 2) / np.where(angle > 0, angle, 1.0), 0.5)
    return from_quaternion(np.concatenate([np.cos(angle / 2), half * v], axis=1))


def quaternion(m):
    """Shepperd's way: by the largest of the four, its sign positive."""
    diagonal = np.array([np.trace(m), *np.diag(m)])
    k = int(diagonal.argmax())
    if k == 0:
        q = np.array([1 + np.trace(m), m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    else:
        i, j, h = k - 1, k % 3, (k + 1) % 3
        q = np.zeros(4)
        q[0], q[k] = m[h, j] - m[j, h], 1 + m[i, i] - m[j, j] - m[h, h]
        q[j + 1], q[h + 1] = m[j, i] + m[i, j], m[h, i] + m[i, h]
    q = q / np.linalg.norm(q)
    return q if q[0] >= 0 else -q


def from_quaternion(q):
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def zyx(m):
    """Degrees about Z, the new Y, the newest X."""
    return np.degrees([
        np.arctan2(m[1, 0], m[0, 0]),
        np.arctan2(-m[2, 0], np.hypot(m[0, 0], m[1, 0])),
        np.arctan2(m[2, 1], m[2, 2]),
    ])


def from_zyx(degrees):
    a, b, c = np.radians(degrees).T
    ca, sa, cb, sb, cc, sc = np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(c), np.sin(c)
    rows = [
        [ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
        [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
        [-sb, cb * sc, cb * cc],
    ]
    return np.moveaxis(np.array(rows), 2, 0)
