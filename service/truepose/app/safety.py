"""Who may reach a service that starts, and how: what would let in everybody is refused with a sentence."""

import ssl
from typing import Final

import uvicorn

from truepose.app.errors import UnsafeStartError
from truepose.settings import Settings

_OPEN: Final = (
    "--no-accounts lets in whoever reaches the service, so it is for this computer alone: leave "
    "out --host, --allowed-host and --behind-proxy, or leave out --no-accounts."
)
_HALF: Final = "TLS needs both: --tls-certificate FILE and --tls-key FILE."


def require_safe(settings: Settings) -> None:
    """Raise UnsafeStartError where a service would let in whoever reaches it."""
    if not settings.accounts and not settings.reached_from_here_alone:
        raise UnsafeStartError(_OPEN)
    if (settings.tls_certificate is None) != (settings.tls_key is None):
        raise UnsafeStartError(_HALF)


def speak_tls(config: uvicorn.Config, settings: Settings) -> str:
    """Have a server speak TLS 1.2 or newer where there is a certificate; return the scheme of its addresses.

    Raises UnsafeStartError where certificate and key cannot be used.
    """
    config.load()
    if settings.tls_certificate is None or settings.tls_key is None:
        return "http"
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(settings.tls_certificate, settings.tls_key)
    except (OSError, ssl.SSLError) as error:
        raise UnsafeStartError(
            f"{settings.tls_certificate} and {settings.tls_key} are no certificate and its key ({error})."
        ) from error
    config.ssl = context
    return "https"
