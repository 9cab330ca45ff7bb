"""Corrections: a file of targets in, the same with corrected numbers out."""

import hashlib
import math
from dataclasses import dataclass, replace
from pathlib import PureWindowsPath
from typing import Annotated, Any, Final, Literal, get_args
from urllib.parse import quote

from fastapi import Query, Request, Response, status
from fastapi.exceptions import RequestValidationError
from pydantic import Field
from starlette.datastructures import UploadFile

from truepose.analysis.job_queue.file_tasks import MOST_TARGETS, TargetsFile
from truepose.domain.correction import CorrectedTargets
from truepose.domain.errors import ConfigurationError
from truepose.exchange.programs.correction_request import CorrectionRequest, branch_named, frame_defined
from truepose.exchange.programs.pose_notation import Order
from truepose.exchange.programs.program import TargetConventions
from truepose.exchange.results.corrections import CorrectionDocument, correction_of
from truepose.exchange.results.document import Quantity
from truepose.kinematics.inverse import BRANCH_NAMES
from truepose.messages.catalogue import english
from truepose.messages.message import message
from truepose.storage.records import CorrectionRecord
from truepose.web.api.jobs import JobReply, queued_job
from truepose.web.context import Here
from truepose.web.resources import (
    LIST,
    LIST_OF_RECORD,
    READ,
    Id,
    IdempotencyKey,
    Paged,
    Sender,
    problems,
    receiving,
    request_key,
    resource,
    sending,
    while_present,
)
from truepose.web.schemas import RecordedAt, RecordId, Reply, Simulated


class AskedReply(Reply):
    """Options used to interpret the file; null for the default of the file format."""

    frame: str | None = None
    define: list[str] = Field([], description="Definitions of frames that the file refers to by name only.")
    branch: str | None = None
    angles: str | None = None
    coupled: bool = Field(False, description="True if FANUC joint 3 is measured from the horizontal.")
    as_written: bool = Field(
        False,
        description="True if the numbers are used as written, even if another unit or frame fits better.",
    )
    beside: list[str] = Field([], description="Names of the accompanying files.")


class CorrectionReply(Reply):
    """A stored correction of a file of targets."""

    id: RecordId
    recorded_at: RecordedAt
    job_id: RecordId
    model_id: RecordId
    robot: str = Field(examples=["ABB IRB 120"])
    simulated: Simulated
    name: str = Field(description="Name of the file.", examples=["weld.mod"])
    original_sha256: str
    corrected_sha256: str
    asked: AskedReply
    document: CorrectionDocument
    left_alone_count: int = Field(
        description="Number of uncorrected statements; the document lists the first 500."
    )
    largest_shift_mm: Quantity = Field(
        description="Largest distance from target to corrected position; null if no target was corrected."
    )
    cautions: list[str] = Field(
        description="Effects not included in the predictions, and statements that were not understood."
    )
    file_url: str = Field(examples=["/api/v1/corrections/3/file"])
    targets_url: str = Field(examples=["/api/v1/corrections/3/targets"])


class TargetReply(Reply):
    """A target of a file."""

    number: int = Field(ge=1, description="Number of the target in the file, starting at 1.")
    name: str
    line: int
    status: str = Field(examples=["ok"])
    place_mm: list[Quantity] = Field(
        description="Target position of the origin of the flange frame, in the base frame."
    )
    shift_mm: list[Quantity] = Field(
        description="Shift from the target position to the position sent to the controller."
    )
    u_mm: Quantity = Field(description="Standard uncertainty of the attained tool position, per axis.")
    outside_mm: Quantity = Field(
        description="Distance of the flange frame outside the measured zone; null if the zone is unknown."
    )
    moved_deg: Quantity = Field(description="Largest joint difference from the controller's own solution.")


def correction_reply(record: CorrectionRecord) -> CorrectionReply:
    """Return a correction as it travels."""
    found, path = record.correction, f"/api/v1/corrections/{record.id}"
    return CorrectionReply.of(
        record,
        asked=AskedReply(**record.asked),
        document=correction_of(found.totals, found.left_alone),
        left_alone_count=found.left_alone_count,
        largest_shift_mm=found.largest_shift_mm,
        cautions=list(map(english, found.cautions)),
        file_url=f"{path}/file",
        targets_url=f"{path}/targets",
    )


def target_replies(targets: CorrectedTargets, after: int, limit: int) -> list[TargetReply]:
    """Return some targets as they travel, from the one behind number `after` on."""
    return [
        TargetReply(
            number=row + 1,
            name=targets.names[row],
            line=int(targets.lines[row]),
            status=targets.statuses[row],
            place_mm=targets.place_mm[row].tolist(),
            shift_mm=targets.shift_mm[row].tolist(),
            u_mm=float(targets.uncertainty_mm[row]),
            outside_mm=float(targets.outside_mm[row]),
            moved_deg=math.degrees(targets.moved_rad[row]),
        )
        for row in range(after, min(after + limit, len(targets.names)))
    ]


router = resource(tags=["corrections"])
_RECEIVING_S: Final = 60.0  # 16 MB at 2 Mbit/s
_MOST_FILES: Final = 20
_LONGEST_NAME: Final = 200
_FILE = {"type": "string", "format": "binary"}
_FORM = {
    "type": "object",
    "required": ["file"],
    "properties": {
        "file": {**_FILE, "description": "The program; its file extension gives the format."},
        "beside": {
            "type": "array",
            "items": _FILE,
            "description": "Accompanying files, which are read but not corrected.",
        },
    },
}
_BODY: dict[str, Any] = {
    "requestBody": {"required": True, "content": {"multipart/form-data": {"schema": _FORM}}}
}
_NO_FILE: Final = {
    "loc": ("body", "file"),
    "msg": "a robot program or a table of targets is required",
    "type": "missing",
}
_ANY_FILE = {"application/octet-stream": {"schema": _FILE}}
Frame = Annotated[
    Literal["world", "base"] | None,
    Query(
        description="Frame of the targets. By default, the frame of the readings for a table and the robot "
        "base for a program."
    ),
]
Define = Annotated[
    list[Annotated[str, Query(max_length=500)]] | None,
    Query(
        max_length=50,
        description="For a program: a tool or work object that is referred to by name only, "
        "NAME=x,y,z,qw,qx,qy,qz.",
        examples=[["tGun=0,0,150,1,0,0,0"]],
    ),
]
Branch = Annotated[
    str | None,
    Query(
        description="For a program: branch to use for poses that do not state a branch.",
        json_schema_extra={"enum": list(BRANCH_NAMES)},
    ),
]
ANGLES: Final = get_args(Order)
Angles = Annotated[Order | None, Query(description="For G-code: axes of the angles A, B, C.")]
Coupled = Annotated[
    bool,
    Query(
        description="For FANUC: joint 3 is measured from the horizontal; joint targets are corrected "
        "accordingly."
    ),
]
AsWritten = Annotated[
    bool,
    Query(
        description="True: correct the targets even if another unit or frame fits better or nearly all are "
        "out of reach."
    ),
]


@dataclass(frozen=True, slots=True)
class _SentFiles:
    """The files of a form, and the fingerprint of all of it."""

    name: str
    data: bytes
    beside: dict[str, bytes]

    @property
    def fingerprint(self) -> bytes:
        """What tells another form from this one."""
        files = {self.name: self.data, **self.beside}
        return repr({name: hashlib.sha256(data).hexdigest() for name, data in files.items()}).encode()


@router.post(
    "/models/{id}/corrections",
    status_code=status.HTTP_202_ACCEPTED,
    responses=problems(400, 404, 408, 409, 413, 415, 422, 503),
    openapi_extra=_BODY,
)
async def correct_file(
    here: Here,
    id: Id,
    request: Request,
    response: Response,
    frame: Frame = None,
    define: Define = None,
    branch: Branch = None,
    angles: Angles = None,
    coupled: Coupled = False,
    as_written: AsWritten = False,
    key: IdempotencyKey = None,
    sender: Sender = "",
) -> JobReply:
    """Correct a robot program or a table of targets, as `truepose correct` does.

    The file is read before the response; an unusable file is refused with a sentence that gives the location.
    RAPID, KRL, LS, URScript, INFORM, VAL3, G-code, JSON and CSV are recognised by the file extension. The
    result of the job is the correction. The job fails and nothing is written if the numbers appear to be in
    another unit or frame or if nearly all targets are out of reach, unless `as_written` is set. For more than
    100,000 targets, use the command, which accepts tables of any length.
    """
    model = (await here.results.model(id)).model
    asked = {
        "frame": frame,
        "define": define or [],
        "branch": branch,
        "angles": angles,
        "coupled": coupled,
        "as_written": as_written,
    }
    meant = CorrectionRequest(
        meant=None if frame is None else TargetConventions(frame),
        defined=dict(frame_defined(text, "define") for text in define or []),
        branch=None if branch is None else branch_named(branch, "branch"),
        angles=angles,
        coupled=coupled,
        as_written=as_written,
        most_targets=MOST_TARGETS,
    )
    async with here.campaign_desk.uploads.turn():
        # Before the file is received: where no job can be queued nobody sends 16 MB for nothing. A request
        # with a key may have its job already, which only its file tells.
        if key is None:
            here.job_desk.require_room()
        sent = await _received(request)
        file = TargetsFile(model, sent.name, sent.data, replace(meant, beside=sent.beside))
        await while_present(request, here.campaign_desk.uploads.check(file))
        asked = {**asked, "beside": list(sent.beside)}
        said = repr(asked).encode() + sent.fingerprint
        by_key = None if key is None else request_key(request, key, said)
        number = await here.job_desk.correct(id, file, asked, by_key, sender)
    return await queued_job(here, number, response)


@router.get("/models/{id}/corrections", responses=LIST_OF_RECORD)
async def list_corrections_of_model(here: Here, id: Id, paging: Paged) -> list[CorrectionReply]:
    """List the corrections made with a model, oldest first."""
    await here.results.model(id)
    return paging.shown(await here.corrections.of_model(id, paging.page), correction_reply)


@router.get("/corrections", responses=LIST)
async def list_corrections(here: Here, paging: Paged) -> list[CorrectionReply]:
    """List corrections, oldest first."""
    return paging.shown(await here.corrections.page(paging.page), correction_reply)


@router.get("/corrections/{id}", responses=READ)
async def get_correction(here: Here, id: Id) -> CorrectionReply:
    """Return the result of a correction: counts, extreme values and uncorrected statements."""
    return correction_reply(await here.corrections.get(id))


@router.get("/corrections/{id}/targets", responses=LIST_OF_RECORD)
async def list_targets(here: Here, id: Id, paging: Paged) -> list[TargetReply]:
    """List the targets of a file with their results, in the order of the file."""
    targets, page = await here.corrections.targets(id), paging.page
    total, last = len(targets.names), page.after + page.limit
    paging.say(total, last if last < total else None)
    return target_replies(targets, page.after, page.limit)


@router.get(
    "/corrections/{id}/file",
    response_class=Response,
    responses=sending("The corrected file.", _ANY_FILE) | READ,
)
async def download_corrected(here: Here, id: Id) -> Response:
    """Download the corrected file; in a program, only the numbers of the targets are changed."""
    record = await here.corrections.get(id)
    saved_as = quote(corrected_name(record.name))
    headers = {"Content-Disposition": f"attachment; filename*=UTF-8''{saved_as}"}
    return Response(await here.corrections.file(id), media_type="application/octet-stream", headers=headers)


def corrected_name(name: str) -> str:
    """Return how a corrected file is called."""
    path = PureWindowsPath(name)
    return f"{path.stem}-corrected{path.suffix}"


async def _received(request: Request) -> _SentFiles:
    """Return the files of a form; raises RequestValidationError where there is none."""
    async with (
        receiving(_RECEIVING_S, "file", "nothing was stored"),
        request.form(max_files=_MOST_FILES) as form,
    ):
        sent = form.get("file")
        if not isinstance(sent, UploadFile) or not sent.filename:
            raise RequestValidationError([_NO_FILE])
        beside = [one for one in form.getlist("beside") if isinstance(one, UploadFile) and one.filename]
        name, data = await _read(sent)
        return _SentFiles(name, data, await _all(beside, name))


async def _all(files: list[UploadFile], name: str) -> dict[str, bytes]:
    """Return files by name; raises ConfigurationError where two have the same one."""
    found: dict[str, bytes] = {}
    for file in files:
        beside, data = await _read(file)
        if beside in found or beside == name:
            raise ConfigurationError(message("refused.same_file", name=beside))
        found[beside] = data
    return found


async def _read(file: UploadFile) -> tuple[str, bytes]:
    name = PureWindowsPath(file.filename or "").name  # some clients send the whole path
    if len(name) > _LONGEST_NAME:
        raise ConfigurationError(message("refused.long_name", most=_LONGEST_NAME))
    return name, await file.read()
