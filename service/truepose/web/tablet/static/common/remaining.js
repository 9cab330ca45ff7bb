// How much time is left, as people say it.

const SOON_S = 45;

export function remaining(seconds, texts) {
  return seconds < SOON_S ? texts.say("progress.soon") : texts.say("progress.left", { time: texts.duration(seconds) });
}
