// Times in the reader's language and time zone.

import { getLanguage } from "./text.js";

const UNITS = [
  ["day", 86_400_000],
  ["hour", 3_600_000],
  ["minute", 60_000],
] as const;

/** Return the browser's own variant of the page's language, such as en-GB. */
const findLocale = (): string =>
  navigator.languages.find((tag) => tag.split("-")[0] === getLanguage().code) ?? getLanguage().code;

/** Return a time with its day and time zone. */
export const formatTime = (time: string): string =>
  new Intl.DateTimeFormat(findLocale(), {
    ...{ weekday: "short", day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" },
    timeZoneName: "short",
  }).format(new Date(time));

/** Return a time in short, for tables. */
export const formatShortTime = (time: string): string =>
  new Intl.DateTimeFormat(findLocale(), { day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" }).format(
    new Date(time),
  );

/** Return how long it is until a time, or since then, as in "in 2 days" or "5 minutes ago". */
export function formatDistance(milliseconds: number): string {
  const [unit, length] = UNITS.find(([, length]) => Math.abs(milliseconds) >= 2 * length) ?? UNITS[2];
  return new Intl.RelativeTimeFormat(getLanguage().code).format(Math.trunc(milliseconds / length), unit);
}

/** Return a time as a field for local times takes it. */
export function writeLocalTime(time: Date): string {
  const digits = (value: number) => String(value).padStart(2, "0");
  const date = [time.getFullYear(), digits(time.getMonth() + 1), digits(time.getDate())].join("-");
  return `${date}T${digits(time.getHours())}:${digits(time.getMinutes())}`;
}
