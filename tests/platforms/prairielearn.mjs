/**
 * PrairieLearn's question server without its database: `tsx prairielearn.mjs SOFTWARE COURSE`.
 *
 * A line of standard input is {question, make, …}: `make` is "variant", "submission" (of a variant, from a form), or
 * "pages" (of a variant, and of a submission). The answer is a line of standard output that begins with "> ": what was
 * made, and what a course's staff would be told was wrong with the question.
 */

import readline from 'node:readline';

const [software, path] = process.argv.slice(2);
const source = `${software}/apps/prairielearn/src`;
const { config } = await import(`${source}/lib/config.ts`);
const own = { devMode: true, workersExecutionMode: 'native', workersCount: 1 };
Object.assign(own, { questionTimeoutMilliseconds: 300_000, workerPingTimeoutMilliseconds: 300_000 });
Object.assign(config, own);
const [assets, callers, freeform] = await Promise.all(
  ['lib/assets', 'lib/code-caller/index', 'question-servers/freeform'].map((name) => import(`${source}/${name}.ts`)),
);
await assets.init();
await callers.init();
await freeform.init();

const course = { id: '1', path, commit_hash: 'run', questions_receive_user_data: false };
const caller = { userId: '1', groupId: null, variantCourse: course };
const locals = {
  urlPrefix: '/pl',
  questionUrl: '/question/',
  baseUrl: '/',
  workspaceUrl: null,
  externalImageCaptureUrl: null,
  clientFilesQuestionUrl: '/files',
  clientFilesCourseUrl: '/course',
  clientFilesQuestionGeneratedFileUrl: '/generated',
  showCorrectAnswer: true,
  allowAnswerEditing: true,
};
const whole = { id: '1', variant_seed: '7', options: {}, preferences: {}, broken: false, broken_at: null, num_tries: 0 };

/** A variant, as lib/question-variant.ts makes it. */
async function variant(question, told) {
  const generated = told(await freeform.generate(question, course, whole.variant_seed, {}, caller));
  return { ...whole, ...told(await freeform.prepare(question, course, { ...whole, ...generated }, caller)) };
}

/** A submission, as lib/grading.ts saves and grades it. */
async function submission(question, told, asked, form) {
  const handedIn = { submitted_answer: form, raw_submitted_answer: structuredClone(form), gradable: true };
  const parsed = told(await freeform.parse(handedIn, asked, question, course, caller));
  const saved = { id: '1', broken: false, score: null, partial_scores: null, ...handedIn, ...parsed };
  if (!saved.gradable) return saved;
  return { ...saved, ...told(await freeform.grade(saved, asked, question, course, caller)) };
}

/** The panels of a question's page: of a submission its own, else the question and its answer. */
async function pages(question, told, asked, given) {
  const submissions = given === null ? [] : [given];
  const renderSelection = { question: given === null, submissions: true, answer: given === null };
  return told(
    await freeform.render({
      renderSelection, variant: asked, question, submission: given, submissions, course, locals, caller,
    }),
  );
}

for await (const line of readline.createInterface({ input: process.stdin })) {
  const { question: directory, make, variant: asked, form, submission: given } = JSON.parse(line);
  const question = { id: '1', course_id: '1', directory, share_publicly: false, share_source_publicly: false };
  const issues = [];
  const told = ({ courseIssues, data }) => {
    issues.push(...courseIssues.map((issue) => `${issue.message} ${issue.data?.outputBoth ?? ''}`));
    return data;
  };
  let made = null;
  try {
    if (make === 'variant') made = await variant(question, told);
    else if (make === 'submission') made = await submission(question, told, asked, form);
    else made = await pages(question, told, asked, given);
  } catch (error) {
    issues.push(error.stack);
  }
  process.stdout.write(`> ${JSON.stringify({ made, issues })}\n`);
}
process.exit(0);
