"""Styles, scripts and texts that a browser has from an earlier test: to fetch them takes longer than most."""

_KEPT = (b"cache-control", b"max-age=86400")


class KeptFiles:
    """A service whose files a browser keeps; by itself it is asked for each again: it may be a newer one."""

    def __init__(self, app):
        self._app = app

    async def __call__(self, scope, receive, send):
        is_file = scope["type"] == "http" and scope["path"].startswith("/static/")
        await self._app(scope, receive, _keeping(send) if is_file else send)


def _keeping(send):
    async def say(message):
        if message["type"] == "http.response.start" and message["status"] == 200:
            others = [header for header in message["headers"] if header[0].lower() != _KEPT[0]]
            message = {**message, "headers": [*others, _KEPT]}
        await send(message)

    return say
