"""What the emScon server does for every command: a request in, steps out.

The state (settings, tracker) outlives connections. It is an AT401, or with a probe in the scenario an AT901.
Commands that they lack here (point lists, continuous modes other than that by time, of an AT401 that one and
probes too) are answered NotImplemented.
"""

from collections.abc import Mapping

from truepose_drivers.leica_emscon import protocol
from truepose_drivers.leica_emscon.protocol.settings import MeasMode
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.leica_emscon.coordinates import Quantity
from truepose_simulators.instruments.leica_emscon.head_commands import Aiming, initialised_only
from truepose_simulators.instruments.leica_emscon.measurement_commands import Shooting
from truepose_simulators.instruments.leica_emscon.parameters import (
    COMPENSATION,
    CONTINUOUS_TIME,
    ENVIRONMENT,
    MODE,
    PARAMETERS,
    REFLECTOR,
    Parameter,
    not_finite,
    wrong_parameter,
)
from truepose_simulators.instruments.leica_emscon.probe import Poses, Probe
from truepose_simulators.instruments.leica_emscon.settings import Handler, HangUp, ServerSettings, Steps
from truepose_simulators.instruments.leica_emscon.status import (
    COMPENSATION_IDS,
    REFLECTOR_IDS,
    StatusReports,
    compensation,
    description,
    reflectors,
)

_DESCRIBED_QUANTITIES: Mapping[str, Quantity] = {
    "max_distance": Quantity.LENGTH,
    "min_distance": Quantity.LENGTH,
    "accuracy_adm_distance": Quantity.LENGTH,
    "std_dev_dist_offset_adm": Quantity.LENGTH,
    "hz_angle_range": Quantity.ANGLE,
    "vt_angle_range": Quantity.ANGLE,
    "field_of_view": Quantity.ANGLE,
    "measurement_range": Quantity.ANGLE,
    "std_dev_angle_const": Quantity.ANGLE,
}


class Dialogue:
    """One server's side of the conversation."""

    def __init__(self, cell: Cell) -> None:
        self.settings = ServerSettings()
        self.last_status: int = protocol.ResultStatus.ALL_OK
        self.aiming = Aiming(cell, self.settings)
        probe = cell.scenario.probe
        self._poses = None if probe is None else Poses(Probe(cell, probe), self.settings)
        self.shooting = Shooting(cell, self.settings, self._poses)
        self._cell = cell
        self._handlers: dict[int, Handler] = {
            protocol.Command.EXIT_APPLICATION: self._exit,
            protocol.Command.GET_REFLECTORS: self._list_reflectors,
            protocol.Command.GET_COMPENSATIONS: self._list_compensations,
            protocol.Command.GET_COMPENSATIONS2: self._list_compensations,
            protocol.Command.SET_LONG_SYSTEM_PARAMETER: self._set_long_parameter,
            protocol.Command.GET_LONG_SYSTEM_PARAMETER: self._get_long_parameter,
            protocol.Command.SET_DOUBLE_SYSTEM_PARAMETER: self._set_double_parameter,
            protocol.Command.GET_DOUBLE_SYSTEM_PARAMETER: self._get_double_parameter,
            protocol.Command.RESTORE_STARTUP_CONDITIONS: self._restore_start,
            protocol.Command.GO_AND_MEASURE: initialised_only(cell, self._go_and_measure),
            protocol.Command.STOP_MEASUREMENT: self._stop,
            protocol.Command.CLEAR_COMMAND_QUEUE: self._acknowledge,
            protocol.Command.SWITCH_LASER: self._acknowledge,  # a diode: nothing to warm up
            **StatusReports(cell, self.settings, lambda: self.last_status).handlers(),
            **self.aiming.handlers(),
            **self.shooting.handlers(),
            **({} if self._poses is None else self._poses.handlers()),
        }
        for parameter in self._parameters():
            self._handlers[parameter.setter] = self._setter(parameter)
            self._handlers[parameter.getter] = self._getter(parameter)
        self._handlers[protocol.Command.GET_ENVIRONMENT_PARAMS] = self._get_environment

    def handle(self, request: protocol.Request) -> Steps:
        """Return what the server does for a request, step by step as it is asked for."""
        for step in self._steps(request):
            # Asking how the last command ended is not itself the last command.
            if (
                isinstance(step, protocol.Answer | protocol.ErrorReport)
                and step.command != protocol.Command.GET_SYSTEM_STATUS
            ):
                self.last_status = step.status
            if not isinstance(step, protocol.StatusChange) or self.settings.flag("send_unsolicited_messages"):
                yield step

    def _steps(self, request: protocol.Request) -> Steps:
        status = not_finite(request.values)
        if status != protocol.ResultStatus.ALL_OK:
            return iter([protocol.Answer(request.command, status)])
        handler = self._handlers.get(request.command)
        if handler is not None:
            return handler(request)
        described = description(request.command, self._cell)
        if described is not None:
            return iter([protocol.Answer(request.command, values=self._in_user_units(described))])
        return iter([protocol.Answer(request.command, protocol.ResultStatus.NOT_IMPLEMENTED)])

    def _in_user_units(self, described: protocol.Record) -> protocol.Record:
        to_wire = self.settings.units.to_wire
        for name, quantity in _DESCRIBED_QUANTITIES.items():
            if name in described:
                described[name] = to_wire(quantity, described.number(name))
        return described

    def _setter(self, parameter: Parameter) -> Handler:
        def handle(request: protocol.Request) -> Steps:
            status = parameter.fault(request.values) or self._fault(parameter, request.values)
            if status == protocol.ResultStatus.ALL_OK:
                self.settings.keep(parameter, request.values)
            yield protocol.Answer(request.command, status)
            if status == protocol.ResultStatus.ALL_OK:
                yield protocol.StatusChange(parameter.event)

        return handle

    def _fault(self, parameter: Parameter, values: protocol.Record) -> int:
        """Status of members whose validity depends on this tracker."""
        if parameter is MODE and values["meas_mode"] not in self._modes:
            return protocol.ResultStatus.NOT_IMPLEMENTED
        if parameter is REFLECTOR and values["internal_reflector_id"] not in REFLECTOR_IDS:
            return wrong_parameter(1)
        if parameter is COMPENSATION and values["internal_compensation_id"] not in COMPENSATION_IDS:
            return protocol.ResultStatus.NO_SUCH_COMPENSATION
        return protocol.ResultStatus.ALL_OK

    @property
    def _modes(self) -> tuple[MeasMode, ...]:
        if self._poses is None:
            return (MeasMode.STATIONARY,)
        return MeasMode.STATIONARY, MeasMode.STATIONARY_6D, MeasMode.CONTINUOUS_TIME

    def _parameters(self) -> list[Parameter]:
        """Return what can be set here: an AT40x measures nothing continuously."""
        return [one for one in PARAMETERS if one is not CONTINUOUS_TIME or self._poses is not None]

    def _getter(self, parameter: Parameter) -> Handler:
        def handle(request: protocol.Request) -> Steps:
            yield protocol.Answer(request.command, values=self.settings.show(parameter))

        return handle

    def _get_environment(self, request: protocol.Request) -> Steps:
        """With the weather station connected its sensors count, otherwise what the user has set."""
        if self.settings.weather_station_read:
            yield protocol.Answer(request.command, values=self.shooting.air())
        else:
            yield protocol.Answer(request.command, values=self.settings.show(ENVIRONMENT))

    def _go_and_measure(self, request: protocol.Request) -> Steps:
        aim = self.aiming.aim_of(request.values)
        if aim is None:
            yield protocol.Answer(request.command, wrong_parameter(1))
            return
        yield from self.aiming.go_and_lock(aim, self.aiming.search_radius_mm)
        yield from self.shooting.stationary(request.command)

    def _list_reflectors(self, request: protocol.Request) -> Steps:
        to_wire = self.settings.units.to_wire
        for item in reflectors():
            item["surface_offset"] = to_wire(Quantity.LENGTH, item.number("surface_offset"))
            yield protocol.Answer(request.command, values=item)

    def _list_compensations(self, request: protocol.Request) -> Steps:
        yield protocol.Answer(request.command, values=compensation(protocol.Command(request.command)))

    def _set_long_parameter(self, request: protocol.Request) -> Steps:
        number, value = (request.values.integer(name) for name in ("system_param", "parameter"))
        status = self.settings.set_long_parameter(number, value)
        yield protocol.Answer(request.command, status)

    def _get_long_parameter(self, request: protocol.Request) -> Steps:
        yield _told(request, self.settings.long_parameters)

    def _set_double_parameter(self, request: protocol.Request) -> Steps:
        number, value = request.values.integer("system_param"), request.values.number("parameter")
        yield protocol.Answer(request.command, self.settings.set_double_parameter(number, value))

    def _get_double_parameter(self, request: protocol.Request) -> Steps:
        yield _told(request, self.settings.double_parameters)

    def _restore_start(self, request: protocol.Request) -> Steps:
        self.settings.restore_start()
        yield protocol.Answer(request.command)
        yield protocol.StatusChange(protocol.SystemStatusChange.SYSTEM_SETTINGS_CHANGED)

    def _acknowledge(self, request: protocol.Request) -> Steps:
        yield protocol.Answer(request.command)

    def _stop(self, request: protocol.Request) -> Steps:
        """Acknowledge; the server has broken off what was running."""
        yield protocol.Answer(request.command)
        yield protocol.StatusChange(protocol.SystemStatusChange.MEAS_STATUS_READY)

    def _exit(self, request: protocol.Request) -> Steps:
        yield protocol.Answer(request.command)
        yield HangUp()


def _told(request: protocol.Request, parameters: Mapping[int, protocol.Value]) -> protocol.Answer:
    """Return the answer that tells one of the system parameters."""
    number = request.values.integer("system_param")
    value = parameters.get(number)
    if value is None:
        return protocol.Answer(request.command, wrong_parameter(1))
    return protocol.Answer(request.command, values=protocol.Record(system_param=number, parameter=value))
