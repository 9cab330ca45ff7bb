// Whatever is asked of the service is answered in the language of the page; its units are in a cookie.

export function inItsWords(request = {}) {
  return { ...request, headers: { "Accept-Language": document.documentElement.lang, ...request.headers } };
}
