// The words of BIP1, which `bipc migrate` reads (compiler/docs/bip1.md). C code between braces is one run of text here: what of it BIP2 can say is
// read again by the rules `code`, `guardCode` and `dataCode`. No actions; nothing is unmatchable.
lexer grammar Bip1Lexer;

// ---- reserved -------------------------------------------------------------------------------------------------------
MODEL: 'model'; END: 'end'; ATOMIC: 'atomic' | 'atom'; COMPOUND: 'compound'; COMPONENT: 'component'; CONTAINS: 'contains';
CONNECTOR: 'connector'; PORT: 'port'; TYPE: 'type'; EXPORT: 'export'; IS: 'is'; DATA: 'data'; DEFINE: 'define';
COMPLETE: 'complete'; INCOMPLETE: 'incomplete'; BEHAVIOR: 'behavior' | 'behaviour'; STATE: 'state'; PLACE: 'place';
INITIAL: 'initial'; ON: 'on'; INTERNAL: 'internal'; PROVIDED: 'provided'; DO: 'do'; UP: 'up'; DOWN: 'down'; TO: 'to';
FROM: 'from'; PRIORITY: 'priority'; IF: 'if'; ELSE: 'else'; TRUE: 'true'; FALSE: 'false';

// ---- names wherever no construct begins with the word (compiler/parse/parse_bip1.cpp makes them so) ---------------------
HEADER: 'header' | 'include'; CLOCK: 'clock';
AS: 'as'; WHEN: 'when'; RESET: 'reset'; IN: 'in'; UNIT: 'unit'; LAZY: 'lazy'; DELAYABLE: 'delayable'; EAGER: 'eager';

// ---- names and literals -----------------------------------------------------------------------------------------------
ID: [A-Za-z_] [A-Za-z0-9_]*;
HEX: '0' [xX] [0-9A-Fa-f]+;
INT: [0-9]+;
FLOAT: ([0-9]+ '.' [0-9]* | '.' [0-9]+) EXPONENT? | [0-9]+ EXPONENT;
fragment EXPONENT: [eE] [+-]? [0-9]+;
STRING: '"' STRING_CHAR* '"';
UNCLOSED_STRING: '"' STRING_CHAR* '\\'?;
fragment STRING_CHAR: ~["\\\r\n] | '\\' ~[\r\n];

// ---- punctuation --------------------------------------------------------------------------------------------------------
RAW_OPEN: '{#' -> pushMode(RAW); LBRACE: '{' -> pushMode(CODE); RBRACE: '}';
LPAREN: '('; RPAREN: ')'; LBRACK: '['; RBRACK: ']';
COMMA: ','; SEMI: ';'; DOT: '.'; COLON: ':'; PRIME: '\'';
INC: '++'; DEC: '--'; CHANGE: '+=' | '-=' | '*=' | '/=' | '%='; ARROW: ':=' | '<-';
OROR: '||'; ANDAND: '&&'; EQ: '=='; NE: '!='; LE: '<='; GE: '>='; LT: '<'; GT: '>'; ASSIGN: '=';
PIPE: '|'; CARET: '^'; AMP: '&'; PLUS: '+'; MINUS: '-'; STAR: '*'; SLASH: '/'; PERCENT: '%'; BANG: '!'; TILDE: '~';

// ---- what no parser sees ------------------------------------------------------------------------------------------------
LINE_COMMENT: '//' ~[\r\n]*;
BLOCK_COMMENT: '/*' .*? '*/';
UNCLOSED_COMMENT: '/*' (~'*' | '*'+ ~[*/])* '*'*;
SPACE: [ \t\r\n\f\u00A0]+ -> skip;
STRAY: .;

// `{# … #}`
mode RAW;
RAW_CLOSE: '#}' -> popMode;
RAW_TEXT: ~'#'+ | '#';

// `{ … }`: braces in strings, characters and comments do not count
mode CODE;
CODE_RAW_OPEN: '{#' -> type(RAW_OPEN), pushMode(RAW);
CODE_LBRACE: '{' -> type(LBRACE), pushMode(CODE);
CODE_RBRACE: '}' -> type(RBRACE), popMode;
CODE_TEXT: ~[{}"'/]+ | '"' STRING_CHAR* '"' | '\'' (~['\\\r\n] | '\\' ~[\r\n])* '\'' | '//' ~[\r\n]* | '/*' .*? '*/' | ["'/];
