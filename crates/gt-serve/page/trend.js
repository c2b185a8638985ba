// The trend of one machine: what was read, and the samples that came since.

const NOTHING = Number.NaN;
const numbers = (values) => values.map((value) => value ?? NOTHING);

/** A machine's trend in buckets of one length. */
export class Trend {
  /** Takes the service's answer. */
  constructor(answer, span_ms) {
    this.machine = answer.machine;
    this.bucket_ms = answer.bucket_ms;
    this.span_ms = span_ms;
    this.times = [...answer.times_ms];
    this.series = answer.series.map((own) => ({
      ...own,
      unit: own.unit ?? "",
      min: numbers(own.min),
      max: numbers(own.max),
    }));
    this.gap_ms = this.gap();
  }

  /** Time of the last bucket; null where there is none. */
  get last_ms() {
    return this.times.at(-1) ?? null;
  }

  /** More than this between two buckets is a gap. */
  gap() {
    const steps = [];
    for (let at = 1; at < this.times.length; at++) steps.push(this.times[at] - this.times[at - 1]);
    steps.sort((one, two) => one - two);
    return 2.5 * Math.max(this.bucket_ms, steps[steps.length >> 1] ?? 0);
  }

  /** Takes a sample; false where it is not of these series, so that the trend has to be read again. */
  add(sample, keep) {
    if (sample.series.length !== this.series.length) return false;
    const last = this.last_ms;
    if (last === null) this.times.push(sample.time_ms);
    else if (sample.time_ms < last) return true; // Late ones are in the next reading.
    else if (sample.time_ms >= last + this.bucket_ms) {
      const steps = Math.floor((sample.time_ms - last) / this.bucket_ms);
      this.times.push(last + steps * this.bucket_ms);
    }
    const place = this.times.length - 1;
    this.series.forEach((series, row) => {
      while (series.min.length <= place) {
        series.min.push(NOTHING);
        series.max.push(NOTHING);
      }
      const pair = sample.series[row];
      if (pair === null) return;
      series.min[place] = least(series.min[place], pair[0]);
      series.max[place] = most(series.max[place], pair[1]);
    });
    this.trim(keep);
    return true;
  }

  /** Forgets what is older than the span; more is kept while somebody looks at a part. */
  trim(keep) {
    const oldest = this.last_ms - this.span_ms * (keep ? 3 : 1);
    const out = this.times.findIndex((time) => time >= oldest);
    // In pieces: to move all arrays at each sample would be the most of the work.
    if (out < 16) return;
    this.times.splice(0, out);
    for (const series of this.series) {
      series.min.splice(0, out);
      series.max.splice(0, out);
    }
  }

  /** The place of the bucket that holds a time, or of the nearest; null where there is none. */
  place(time_ms) {
    if (this.times.length === 0) return null;
    const after = this.firstAfter(time_ms);
    return Math.max(0, after - 1);
  }

  /** The first place whose bucket begins after a time. */
  firstAfter(time_ms) {
    let [low, high] = [0, this.times.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time_ms) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** The last bucket of a series that has a value, as {min, max, time_ms}; null where none has. */
  last(series) {
    for (let at = this.times.length - 1; at >= 0; at--) {
      if (Number.isFinite(series.min[at])) {
        return { min: series.min[at], max: series.max[at], time_ms: this.times[at] };
      }
    }
    return null;
  }
}

const least = (one, two) => (two === null || two >= one ? one : two);
const most = (one, two) => (two === null || two <= one ? one : two);
